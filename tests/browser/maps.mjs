// Saved maps: their layers, another map and the truth beside them, the errors, moving and zooming.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { join } from "node:path";
import { visit } from "./lib/page.mjs";
import { decode } from "./lib/png.mjs";
import { shot } from "./lib/shot.mjs";
import { colours, differences, fromBottom, picture } from "./lib/tiles.mjs";
import { LOGS, map, serve } from "./lib/tool.mjs";

const one = () => map("one", LOGS.dense(), "-m", "bayes");
const two = () => map("two", LOGS.dense(), "-m", "certainty");

test("a map's views are its pictures", async () => {
  const server = await serve(one());
  await visit(server, async (page) => {
    assert.equal(await page.page.$eval("#transport", (e) => getComputedStyle(e).display), "none");
    for (const [view, name] of [
      ["combined", "map"],
      ["p_occ", "p_occ"],
      ["class", "class"],
    ]) {
      const wanted = fromBottom(decode(readFileSync(join(one(), `${name}.png`))));
      assert.equal(differences(await picture(server, view), wanted), 0, view);
    }
    const own = await picture(server, "combined");
    await page.click("#axes");
    const canvas = await shot(page);
    for (let row = 2; row < own.height; row += 7) {
      for (let column = 2; column < own.width; column += 7) assert.equal(canvas.cell(column, row), own.at(column, row));
    }
    await page.select("#layers", "log_odds");
    assert.match(await page.text("figcaption"), /^one log_odds$/);
    await page.open("#report-details");
    assert.match(await page.text("#report"), /method\s+bayes/);
  });
  server.close();
});

test("moving and zooming, by pointer and by keys", async () => {
  const server = await serve(one());
  await visit(server, async (page) => {
    const at = async () => (await page.state()).viewport;
    const first = await at();
    const canvas = await (await page.page.$("#canvas-0")).boundingBox();
    const [x, y] = [canvas.x + canvas.width * 0.3, canvas.y + canvas.height * 0.6];
    const under = (v) => [
      v.centre[0] + (x - canvas.x - canvas.width / 2) / v.scale,
      v.centre[1] - (y - canvas.y - canvas.height / 2) / v.scale,
    ];
    await page.page.mouse.move(x, y);
    await page.page.mouse.wheel({ deltaY: -300 });
    await page.ready();
    const near = await at();
    assert.ok(near.scale > 1.5 * first.scale);
    under(near).forEach((v, k) =>
      assert.ok(Math.abs(v - under(first)[k]) < 0.5, `${v} lies under the pointer, not ${under(first)[k]}`),
    );
    await page.page.mouse.down();
    await page.page.mouse.move(x + 50, y + 20, { steps: 4 });
    await page.page.mouse.up();
    await page.ready();
    const moved = await at();
    assert.ok(Math.abs(moved.centre[0] - near.centre[0] + 50 / near.scale) < 1e-6);
    assert.ok(Math.abs(moved.centre[1] - near.centre[1] - 20 / near.scale) < 1e-6);
    await page.key("ArrowRight", "ArrowUp");
    const keyed = await at();
    assert.ok(keyed.centre[0] > moved.centre[0] && keyed.centre[1] > moved.centre[1], "right is +x, up is +y");
    await page.key("0");
    assert.deepEqual(await at(), first);
  });
  server.close();
});

test("against the truth: the levels, the score, a cell's level", async () => {
  const server = await serve(one(), "--truth", "worlds/cartons.toml", "--with", two());
  await visit(server, async (page) => {
    await page.click('[data-view="levels"]');
    const levels = await picture(server, "levels");
    assert.ok(colours(levels) > 4);
    const session = await server.json("api/session");
    assert.match(await page.text("#score"), new RegExp(`danger\\s+${Number(session.score.danger.toPrecision(4))}`));
    // By the legend's colours there are as many cells of a level as the score counts; it counts unknown ones beyond the map too.
    const { entries } = session.sources[0].views.find((v) => v.name === "levels").legend;
    const found = new Map();
    for (let row = 0; row < levels.height; row++) {
      for (let column = 0; column < levels.width; column++) {
        const colour = levels.at(column, row);
        found.set(colour, (found.get(colour) ?? 0) + 1);
      }
    }
    entries.forEach(([name, colour], k) => {
      if (k >= 5) assert.equal(found.get(colour) ?? 0, session.score.levels[k], name);
    });
    const danger = entries[9][1];
    const all = [...Array(levels.width * levels.height).keys()].map((k) => [
      k % levels.width,
      Math.floor(k / levels.width),
    ]);
    const [column, row] = all.find((at) => levels.at(...at) === danger);
    await page.page.mouse.click(...(await page.place(column, row)));
    await page.ready();
    assert.match(await page.text("#cell"), /error_level\s+9/);
    assert.match(await page.text("#cell"), /cartons\s+class\s+occupied/);

    await page.select("#arrangement", "beside");
    assert.deepEqual((await page.state()).panels, [0, 1, "difference"]);
    await page.select("#other", "2");
    assert.deepEqual((await page.state()).panels, [0, 2]);
    const beside = await shot(page);
    await page.select("#arrangement", "over");
    assert.deepEqual((await page.state()).panels, [0]);
    await page.set("#opacity", 100);
    const over = await shot(page);
    assert.notEqual(over.pixels, beside.pixels);
    assert.equal(over.cell(column, row), "#ff0101", "the true wall covers all");
  });
  server.close();
});
