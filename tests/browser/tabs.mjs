// Two tabs on one log follow each other, and a server that ends leaves a page at rest.

import assert from "node:assert/strict";
import { test } from "node:test";
import { visit } from "./lib/page.mjs";
import { shot } from "./lib/shot.mjs";
import { LOGS, serve } from "./lib/tool.mjs";

const METHOD = /method or its parameters were changed elsewhere/;

/** Two tabs of one server. */
const two = (server, what) => visit(server, (first) => visit(server, (second) => what(first, second)));

/** Turns to a tab, and waits until it shows what it found. */
async function turn(page) {
  await page.page.bringToFront();
  await page.page.evaluate(() => window.dispatchEvent(new Event("focus")));
  await page.ready();
}

/** That the tab shows what a reload of it shows. */
async function asReloaded(page) {
  // A notice takes room from the map, and a reload shows all of it.
  if (await page.page.$eval("#notice", (n) => !n.hidden)) await page.click("#notice-close");
  await page.key("0");
  const [seen, says] = [await shot(page), await page.text("#position")];
  await page.page.reload();
  await page.page.waitForFunction(() => window.echogrid !== undefined);
  const { pixels } = await shot(page);
  assert.ok(pixels === seen.pixels, "the picture is that of a reload");
  assert.equal(await page.text("#position"), says);
}

test("a step in one tab after steps in another: nothing old is left in its picture", async () => {
  const server = await serve(LOGS.ring(), "-m", "certainty");
  await two(server, async (first, second) => {
    // The second goes far and back, unseen by the first; then the first takes one step from where it believes to be.
    await turn(first);
    await first.key("PageDown");
    await turn(second);
    await second.key("End", "PageUp");
    // Turned to, a tab would ask where the log is: here it learns that with its step.
    await first.page.evaluate(() => {
      for (const event of ["focus", "visibilitychange"]) {
        window.addEventListener(event, (e) => e.stopImmediatePropagation(), { capture: true });
      }
    });
    await first.page.bringToFront();
    await first.key("ArrowRight");
    assert.equal(await first.position(), (await server.json("api/session")).state.position);
    await asReloaded(first);
  });
  server.close();
});

test("a tab that is turned to shows where the log was brought elsewhere, its cell too", async () => {
  const server = await serve(LOGS.ring(), "-m", "bayes");
  await two(server, async (first, second) => {
    await turn(first);
    await first.page.mouse.click(...(await first.place(60, 40)));
    await first.ready();
    await turn(second);
    await second.key("End");
    await turn(first);
    const { total } = (await first.state()).state;
    assert.equal(await first.position(), total);
    const { cell } = await first.state();
    assert.deepEqual(cell, await server.json("api/cell?column=60&row=40"));
    await first.key("Escape");
    await asReloaded(first);
    assert.equal(await first.page.$eval("#notice", (n) => n.hidden), true);
  });
  server.close();
});

test("a cell's answer is enough to tell that the log was moved elsewhere", async () => {
  const server = await serve(LOGS.ring(), "-m", "bayes");
  await visit(server, async (page) => {
    await page.key("PageDown");
    const { version } = (await page.state()).state;
    await server.json("api/go", { to: 90 });
    await page.page.mouse.click(...(await page.place(60, 40)));
    await page.ready();
    const { state, cell } = await page.state();
    assert.equal(state.position, 90);
    assert.ok(state.version > version && cell.version === state.version);
    await page.key("Escape");
    await asReloaded(page);
  });
  server.close();
});

test("another method in one tab: the other takes it over, and says so", async () => {
  const server = await serve(LOGS.ring(), "-m", "certainty");
  await two(server, async (first, second) => {
    await turn(first);
    await first.set("#slider", 80);
    await first.open("#lanes-details");
    await turn(second);
    await second.open("#lanes-details");
    await second.select("#method-0", "bayes");
    await second.set("#set-0-epsilon", "0.2");
    await second.click("#add-lane");
    await turn(first);
    assert.match(await first.text("#notice-text"), METHOD);
    assert.match(await first.text("#live"), METHOD);
    assert.match(await first.text("figcaption"), /^bayes/);
    assert.equal(await first.page.$eval("#set-0-epsilon", (f) => f.value), "0.2", "its form is the new method's");
    assert.deepEqual((await first.state()).panels, [0, 1, "difference"]);
    assert.equal(await second.page.$eval("#notice", (n) => n.hidden), true, "who changed it is told nothing");
    await asReloaded(first);
    // By a step alone, too.
    await server.json("api/lanes", { lanes: [{ method: "himm", set: {} }] });
    await first.key("ArrowRight");
    assert.match(await first.text("figcaption"), /^himm/);
    assert.match(await first.text("#notice-text"), METHOD);
    await asReloaded(first);
  });
  server.close();
});

test("the browser's GPU goes on with lanes that were made anew elsewhere", async (t) => {
  const server = await serve(LOGS.ring(), "-m", "certainty");
  await visit(
    server,
    async (page) => {
      if (await page.page.$eval("#gpu", (box) => box.disabled)) return t.skip("this browser has no software GPU");
      await page.key("PageDown", "g");
      await server.json("api/lanes", { lanes: [{ method: "bayes", set: {} }] });
      await page.key("PageDown");
      await server.json("api/go", { to: 100 });
      await page.key("ArrowRight");
      assert.equal(await page.position(), 101);
      assert.match(await page.text("#backend"), /^WebGPU: /);
      await page.open("#compute-details");
      const check = await page.text("#gpu-check");
      assert.match(check, /membership differences\s+0\s+value differences\s+0/);
    },
    { gpu: true },
  );
  server.close();
});

test("a server that ends while the log plays: it pauses, says so once, and asks no more", async () => {
  const server = await serve(LOGS.dense(), "-m", "bayes");
  await visit(
    server,
    async ({ page, text }) => {
      await page.$eval("#rate", (field) => {
        field.value = "1";
        field.dispatchEvent(new Event("change", { bubbles: true }));
      });
      await page.select("#rate-by", "reading");
      await page.keyboard.press("Space");
      await new Promise((next) => setTimeout(next, 1300));
      assert.match(await text("#play"), /Pause/);
      server.close();
      await page.waitForFunction(() => !document.getElementById("error").hidden);
      assert.match(await text("#error-text"), /does not answer/);
      assert.match(await text("#play"), /Play/);
      let asked = 0;
      page.on("request", () => (asked += 1));
      await new Promise((next) => setTimeout(next, 1500));
      assert.equal(asked, 0);
    },
    { allow: /Failed to load resource/ },
  );
});
