// Steps through a log: by reading, by scan, to the ends, by slider, by playing; and the map at each is the log's map up to
// there.

import assert from "node:assert/strict";
import { test } from "node:test";
import { mapped } from "./lib/like.mjs";
import { visit } from "./lib/page.mjs";
import { differences, picture } from "./lib/tiles.mjs";
import { LOGS, serve } from "./lib/tool.mjs";

test("each button goes where it says", async () => {
  const server = await serve(LOGS.ring(), "-m", "certainty");
  await visit(server, async (page) => {
    const at = async (selector) => {
      await page.click(selector);
      const { position, scan } = (await page.state()).state;
      return [position, scan];
    };
    const { total, scans } = (await page.state()).state;
    assert.equal(await page.position(), 0);
    assert.deepEqual(await at("#on-reading"), [1, 1]);
    assert.deepEqual(await at("#on-reading"), [2, 1]);
    assert.deepEqual(await at("#back-reading"), [1, 1]);
    const [one, scan] = await at("#on-scan");
    assert.ok(one > 1 && one <= 8, `${one} readings in a scan of eight`);
    assert.equal(scan, 1);
    const [many] = await at("#on-10-scans");
    assert.equal((await page.state()).state.scan, 11);
    assert.match(await page.text("#position"), new RegExp(`^reading ${many} of ${total} · scan 11 of ${scans}`));
    assert.deepEqual(await at("#back-10-scans"), [one, 1]);
    assert.deepEqual(await at("#to-end"), [total, scans]);
    assert.deepEqual((await at("#back-scan"))[1], scans - 1);
    assert.deepEqual(await at("#to-start"), [0, 0]);
    assert.deepEqual(await at("#back-reading"), [0, 0], "nothing lies before the start");
  });
  server.close();
});

test("each key goes where its button goes", async () => {
  const server = await serve(LOGS.ring(), "-m", "bayes");
  await visit(server, async (page) => {
    const at = async (key) => {
      await page.key(key);
      return page.position();
    };
    const { total } = (await page.state()).state;
    assert.equal(await at("ArrowRight"), 1);
    const scan = await at("Shift+ArrowRight");
    assert.ok(scan > 1 && scan <= 8);
    const many = await at("PageDown");
    assert.ok(many > 10 * 3);
    assert.equal(await at("PageUp"), scan);
    assert.equal(await at("ArrowLeft"), scan - 1);
    assert.equal(await at("Shift+ArrowLeft"), 0);
    assert.equal(await at("End"), total);
    assert.equal(await at("Home"), 0);
  });
  server.close();
});

test("the slider, forth and back: the map is that of the readings so far", async () => {
  const log = LOGS.ring();
  const server = await serve(log, "-m", "dempster-shafer");
  await visit(server, async (page) => {
    for (const to of [60, 21, 90]) {
      await page.set("#slider", to);
      assert.equal(await page.position(), to);
      const wanted = await mapped(server, log, "dempster-shafer", { until: to });
      assert.equal(differences(await picture(server, "combined"), wanted), 0, `pixels after ${to} readings`);
    }
  });
  server.close();
});

test("it plays, pauses, and stops at the end", async () => {
  const server = await serve(LOGS.ring(), "-m", "certainty");
  await visit(server, async (page) => {
    const until = (test, ...args) => page.page.waitForFunction(test, { timeout: 10_000 }, ...args);
    await page.set("#rate", 20);
    await page.page.keyboard.press("Space");
    await until(() => window.echogrid.state().state.scan >= 3);
    assert.equal(await page.text("#play"), "❚❚ Pause");
    await page.page.keyboard.press("Space");
    await page.ready();
    const there = await page.position();
    await new Promise((next) => setTimeout(next, 200));
    assert.equal(await page.position(), there, "it stands still");
    await page.select("#rate-by", "reading");
    await page.set("#rate", 1000);
    await page.page.click("#play");
    await until(() => document.getElementById("play").textContent.includes("Play"));
    const { position, total } = (await page.state()).state;
    assert.equal(position, total);
  });
  server.close();
});

test("of a counting sensor model a step is a scan", async () => {
  const server = await serve(LOGS.ring(), "-m", "csm-continuous");
  await visit(server, async (page) => {
    await page.click("#on-reading");
    assert.equal((await page.state()).state.lanes[0].current.kind, "scan");
    assert.match(await page.text("#position"), /^scan 1 of 20$/);
  });
  server.close();
});
