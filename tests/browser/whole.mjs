// The whole log, stepped through in the page: its pictures are those of `echogrid map`, pixel for pixel.

import assert from "node:assert/strict";
import { test } from "node:test";
import { mapped } from "./lib/like.mjs";
import { visit } from "./lib/page.mjs";
import { colours, differences, picture } from "./lib/tiles.mjs";
import { LOGS, real, serve } from "./lib/tool.mjs";

async function same(log, method, walk) {
  const server = await serve(log, "-m", method);
  await visit(server, async (page) => {
    await walk(page);
    const { position, total } = (await page.state()).state;
    assert.equal(position, total);
  });
  const own = await picture(server, "combined");
  assert.ok(colours(own) > 2, "there is something to compare");
  assert.equal(differences(own, await mapped(server, log, method)), 0, `${method}: pixels that differ from map.png`);
  server.close();
}

const atOnce = (page) => page.key("End");

for (const method of ["certainty", "bayes", "dempster-shafer", "himm", "csm-continuous"]) {
  test(`${method}: the rest of the log gives map.png`, () => same(LOGS.ring(), method, atOnce));
}

test("features: the rest of the log gives map.png", () => same(LOGS.dense(), "features", atOnce));

test("truth: the rest of a laser's log gives map.png", () => same(LOGS.laser(), "truth", atOnce));

test("one reading after the other, to the end and back and on again, gives map.png", () =>
  same(LOGS.ring(), "certainty", async (page) => {
    const { total } = (await page.state()).state;
    for (let k = 0; k < total; k++) await page.page.keyboard.press("ArrowRight");
    await page.ready();
    assert.equal(await page.position(), total);
    for (let k = 0; k < total / 2; k++) await page.page.keyboard.press("ArrowLeft");
    await page.ready();
    await page.key("PageUp", "PageDown", "PageDown", "PageDown", "PageDown");
  }));

test("a real log, ten scans at a time, gives map.png", async (t) => {
  const log = real();
  if (!log) return t.skip("no real log");
  await same(log, "bayes", async (page) => {
    for (let k = 0; k < 12; k++) await page.page.keyboard.press("PageDown");
    await page.ready();
    await page.key("End");
  });
});
