// For everybody: names for all controls, keys alone, twice the size, light and dark, little motion.

import assert from "node:assert/strict";
import { test } from "node:test";
import { visit } from "./lib/page.mjs";
import { LOGS, map, serve } from "./lib/tool.mjs";

const CONTROLS = new Set([
  "button",
  "checkbox",
  "textbox",
  "combobox",
  "slider",
  "spinbutton",
  "link",
  "application",
  "DisclosureTriangle",
]);

/** Every control as the browser tells it to a screen reader. */
async function controls(page) {
  const devtools = await page.page.createCDPSession();
  const { nodes } = await devtools.send("Accessibility.getFullAXTree");
  const told = nodes.filter((n) => !n.ignored && CONTROLS.has(n.role?.value));
  return told.map((n) => ({ role: n.role.value, name: n.name?.value ?? "" }));
}

const openAll = (page) => page.page.$$eval("details", (all) => all.forEach((d) => (d.open = true)));

const wide = (page) => page.page.evaluate(() => [document.documentElement.scrollWidth, window.innerWidth]);

test("every control has a name, of a log and of a map", async () => {
  for (const what of [
    [LOGS.ring(), "-m", "certainty", "--beside", "bayes"],
    [map("one", LOGS.dense(), "-m", "bayes"), "--truth", "worlds/cartons.toml"],
  ]) {
    const server = await serve(...what);
    await visit(server, async (page) => {
      await openAll(page);
      if (what.includes("--beside")) await page.key("End");
      await page.ready();
      const all = await controls(page);
      assert.ok(all.length > 10, `${all.length} controls`);
      assert.deepEqual(
        all.filter((c) => !c.name.trim()),
        [],
        "without a name",
      );
      assert.ok(all.some((c) => c.role === "application" && /^Map of /.test(c.name)));
      assert.equal(await page.page.$eval("html", (e) => e.lang), "en");
    });
    server.close();
  }
});

test("Tab reaches every control and shows where it is; keys alone do everything", async () => {
  const server = await serve(LOGS.ring(), "-m", "certainty");
  await visit(server, async (page) => {
    const wanted = new Set(
      await page.page.$$eval("#tools button, #transport button, #slider, canvas, #side > details > summary", (all) =>
        all.filter((e) => e.checkVisibility() && !e.disabled).map((e) => e.id || e.textContent),
      ),
    );
    for (let k = 0; k < 80 && wanted.size; k++) {
      await page.page.keyboard.press("Tab");
      const [name, outlined] = await page.page.evaluate(() => {
        const e = document.activeElement;
        return [e.id || e.textContent, getComputedStyle(e).outlineStyle !== "none"];
      });
      if (wanted.delete(name)) assert.ok(outlined, `${name} shows its focus`);
    }
    assert.deepEqual([...wanted], [], "not reached");
    await page.page.focus("#on-scan");
    await page.key("Enter");
    assert.equal((await page.state()).state.scan, 1);
    await page.key("?");
    assert.equal(await page.page.$eval("#keys", (d) => d.open), true);
    assert.match(await page.text("#keys-list"), /Shift\+→\s+one scan on/);
    await page.key("Escape");
    assert.equal(await page.page.$eval("#keys", (d) => d.open), false);
    await page.key("m", "4");
    const { look } = await page.state();
    assert.deepEqual([look.marks, look.view], [false, "working"]);
    assert.match(await page.text("#live"), /reading \d+ of 117/);
  });
  server.close();
});

test("at 200 % nothing is cut off, with all of it open", async () => {
  const server = await serve(LOGS.ring(), "-m", "certainty", "--beside", "csm-continuous");
  await visit(
    server,
    async (page) => {
      await page.key("End");
      await openAll(page);
      await page.page.mouse.click(...(await page.place(60, 40)));
      await page.ready();
      const [content, window] = await wide(page);
      assert.ok(content <= window, `${content} pixels in ${window}`);
      const cut = await page.page.$$eval("button, select, input, output", (all) =>
        all
          .filter(
            (e) => e.checkVisibility() && !e.closest(".scroll") && e.getBoundingClientRect().right > innerWidth + 0.5,
          )
          .map((e) => e.id || e.textContent),
      );
      assert.deepEqual(cut, []);
    },
    { width: 640, height: 400, ratio: 2 },
  );
  server.close();
});

test("light and dark, as the system has it or as chosen", async () => {
  const server = await serve(LOGS.ring(), "-m", "certainty");
  const light = (page) =>
    page.page.evaluate(() => {
      const [r, g, b] = getComputedStyle(document.body).backgroundColor.match(/\d+/g).map(Number);
      return (r + g + b) / 765;
    });
  await visit(server, async (page) => assert.ok((await light(page)) > 0.8), { scheme: "light" });
  await visit(
    server,
    async (page) => {
      assert.ok((await light(page)) < 0.3);
      await page.click("#theme");
      assert.ok((await light(page)) > 0.8, "chosen: light");
      await page.click("#theme");
      await page.page.reload();
      await page.page.waitForFunction(() => window.echogrid !== undefined);
      assert.ok((await light(page)) < 0.3, "chosen: dark, and kept");
      await page.click("#theme");
    },
    { scheme: "dark" },
  );
  server.close();
});
