// Runs the tests of `echogrid view`'s page in Chromium: node tests/browser/all.mjs. ECHOGRID_BIN names the binary,
// ECHOGRID_CHROMIUM the browser, ECHOGRID_DATA the folder of real logs.

import { after } from "node:test";
import { closeBrowsers } from "./lib/page.mjs";
import { clean } from "./lib/tool.mjs";

after(async () => {
  await closeBrowsers();
  clean();
});

const only = process.argv.slice(2);
const files = ["guard", "steps", "views", "cells", "lanes", "tabs", "told", "save", "maps", "huge", "gpu", "people", "whole"];
for (const file of files.filter((f) => !only.length || only.includes(f))) await import(`./${file}.mjs`);
