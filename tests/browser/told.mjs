// What the page tells beside the map: the log's report, what a shade is, readings that reach nothing, tiles that are long
// in coming.

import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { test } from "node:test";
import { visit } from "./lib/page.mjs";
import { LOGS, inside, serve } from "./lib/tool.mjs";

test("the report of a log: what was read and used, why others were not, bad lines", async () => {
  const path = inside("bad.jsonl");
  writeFileSync(path, `${readFileSync(LOGS.ring(), "utf8")}this is no reading\n`);
  const server = await serve(path, "-m", "bayes");
  await visit(server, async (page) => {
    await page.open("#report-details");
    const report = await page.text("#report");
    assert.match(report, /used\s+117/);
    assert.match(report, /bad lines\s+1/);
    assert.match(await page.text("#report li"), /line \d+/);
  });
  server.close();
});

test("the working view's legend tells what its strongest shade is", async () => {
  const server = await serve(LOGS.ring(), "-m", "certainty", "--beside", "bayes");
  await visit(server, async (page) => {
    await page.set("#slider", 40);
    await page.key("4");
    const { strongest } = await server.json("api/working?lane=0");
    const [first, second] = await page.page.$$eval('[data-legend="working"]', (all) => all.map((e) => e.innerText));
    const [, said] = /interior, strongest: (\S+) \(own\)/.exec(first);
    assert.ok(Math.abs(Number(said) - strongest) < 1e-3 * strongest, `${said} is ${strongest}`);
    assert.match(second, /strongest: \S+ \(\|2·own − 1\|\)/);
    await page.select("#step", "normalised");
    assert.match(await page.text('[data-legend="working"]'), /arc, strongest: \S+ \(normalised\)/);
    await page.open("#reading-details");
    const interior = await page.page.$$eval('[data-lane="0"] tr.interior', ([row]) =>
      [...row.cells].slice(3, 5).map((c) => c.innerText),
    );
    assert.deepEqual(interior, ["–", "–"], "in the interior nothing is cancelled or normalised");
    assert.match(await page.text("#reading"), /time\s+\d+\.\d\d s/);
  });
  server.close();
});

test("a reading beside the grid says that it reaches no cell", async () => {
  const server = await serve(LOGS.ring(), "-m", "bayes", "--bounds=-100,-100,-99,-99");
  await visit(server, async (page) => {
    await page.open("#reading-details");
    await page.key("ArrowRight");
    assert.match(await page.text("#reading"), /Outside the grid: it reaches no cell/);
  });
  server.close();
});

test("tiles that are long in coming are announced, and no longer once they are there", async () => {
  const server = await serve(LOGS.ring(), "-m", "bayes");
  await visit(server, async (page) => {
    let late = 1500;
    await page.page.setRequestInterception(true);
    page.page.on("request", (request) => {
      const wait = request.url().includes("api/tile") ? late : 0;
      setTimeout(() => request.continue(), wait);
    });
    const hidden = () => page.page.$eval(".loading", (note) => note.hidden);
    await page.page.keyboard.press("End");
    await new Promise((next) => setTimeout(next, 150));
    assert.equal(await hidden(), true, "not at once");
    await page.page.waitForFunction(() => !document.querySelector(".loading").hidden);
    await page.ready();
    assert.equal(await hidden(), true);
    late = 0;
  });
  server.close();
});
