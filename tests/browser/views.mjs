// What is shown: the views and layers, each as `echogrid map` draws it; the working of a reading; a feature's case.

import assert from "node:assert/strict";
import { test } from "node:test";
import { mapped } from "./lib/like.mjs";
import { visit } from "./lib/page.mjs";
import { shot } from "./lib/shot.mjs";
import { colours, differences, picture } from "./lib/tiles.mjs";
import { LOGS, serve } from "./lib/tool.mjs";

test("every view is there, on its key and its button, with its legend", async () => {
  const log = LOGS.ring();
  const server = await serve(log, "-m", "certainty");
  await visit(server, async (page) => {
    await page.key("End");
    for (const [key, name] of [
      ["1", "empty"],
      ["2", "full"],
      ["3", "combined"],
      ["4", "working"],
    ]) {
      await page.key(key);
      assert.equal((await page.state()).look.view, name);
      const pressed = await page.page.$$eval('#main-views [aria-pressed="true"]', (all) =>
        all.map((b) => b.textContent),
      );
      assert.deepEqual(pressed, [name]);
      assert.ok(await page.page.$(`[data-legend="${name}"]`), `a legend of ${name}`);
    }
    await page.click('[data-view="full"]');
    assert.equal((await page.state()).look.view, "full");
    for (const layer of ["map", "class", "updates"]) {
      await page.select("#layers", layer);
      assert.match(await page.text("figcaption"), new RegExp(`^certainty ${layer}$`));
      assert.ok(colours(await picture(server, layer)) > 1);
    }
    for (const [view, name] of [
      ["empty", "emp"],
      ["full", "occ"],
      ["class", "class"],
    ]) {
      assert.equal(differences(await picture(server, view), await mapped(server, log, "certainty", { name })), 0, view);
    }
  });
  server.close();
});

test("the canvas shows the tiles, right way up", async () => {
  const server = await serve(LOGS.ring(), "-m", "bayes");
  await visit(server, async (page) => {
    await page.key("End", "m", "o");
    await page.click("#axes");
    const own = await picture(server, "combined");
    const canvas = await shot(page);
    let seen = 0;
    for (let row = 1; row < own.height - 1; row += 2) {
      for (let column = 1; column < own.width - 1; column += 2) {
        assert.equal(canvas.cell(column, row), own.at(column, row), `cell ${column}, ${row}`);
        seen += 1;
      }
    }
    assert.ok(seen > 1000, `${seen} cells`);
    assert.ok(
      differences(own, { ...own, at: (c, r) => own.at(c, own.height - 1 - r) }) > 500,
      "upside down it would differ",
    );
    assert.ok(
      differences(own, { ...own, at: (c, r) => own.at(own.width - 1 - c, r) }) > 500,
      "mirrored it would differ",
    );
  });
  server.close();
});

test("the working of a reading: cells, steps, the table, the outline", async () => {
  const server = await serve(LOGS.ring(), "-m", "certainty");
  await visit(server, async (page) => {
    await page.open("#reading-details");
    // The first reading with an echo has an arc.
    for (let k = 0; k < 20; k++) {
      await page.key("ArrowRight");
      if ((await page.state()).state.lanes[0].current.outcome === "hit") break;
    }
    const told = await server.json("api/working?lane=0");
    assert.ok(told.arc > 0 && told.interior > 0);
    assert.match(await page.text("#reading"), new RegExp(`arc cells\\s+${told.arc}\\b`));
    assert.equal((await page.page.$$("#reading tbody tr")).length, Math.min(200, told.column.length));
    await page.key("4", "o");
    const strongest = told.column.map((_, k) => k).filter((k) => told.region[k] === 1);
    const arc = strongest.reduce((a, b) => (told.strength[a] > told.strength[b] ? a : b));
    const before = await shot(page);
    const red = before.cell(told.column[arc], told.row[arc]);
    assert.ok(parseInt(red.slice(1, 3), 16) > parseInt(red.slice(5, 7), 16) + 60, `${red} is red`);
    await page.select("#step", "normalised");
    assert.equal((await page.state()).look.step, "normalised");
    await page.key("o", "f");
    assert.ok((await shot(page)).pixels !== before.pixels, "the outline is drawn");
  });
  server.close();
});

test("what features made of a reading", async () => {
  const server = await serve(LOGS.dense(), "-m", "features");
  await visit(server, async (page) => {
    await page.key("End");
    await page.open("#reading-details");
    const { case: made } = (await page.state()).state.lanes[0].current;
    assert.ok(["associated", "outlier", "behind", "routine"].includes(made.name));
    assert.ok((await page.text("#reading")).includes(`${made.name}: ${made.about}`));
  });
  server.close();
});
