// A map of 400 million cells of which few are known: opened and looked at without reading all of it.

import assert from "node:assert/strict";
import { rmSync } from "node:fs";
import { test } from "node:test";
import { join } from "node:path";
import { visit } from "./lib/page.mjs";
import { shot } from "./lib/shot.mjs";
import { log, map, serve } from "./lib/tool.mjs";

test("a huge sparse map is shown soon, and so is what lies in it", async () => {
  const path = map("huge", log("room", "ring8", 4), "-m", "bayes", "--bounds=-500,-500,500,500");
  rmSync(join(path, "map.pgm")); // 400 MB that nobody here reads
  const begun = performance.now();
  const server = await serve(path);
  const served = performance.now();
  await visit(server, async (page) => {
    const shown = performance.now();
    const { width, height } = (await server.json("api/session")).grid;
    assert.deepEqual([width, height], [20_000, 20_000]);
    // The room lies right above the middle; zooming in there finds its walls.
    const canvas = await (await page.page.$("#canvas-0")).boundingBox();
    for (let k = 0; k < 8; k++) {
      const [x, y] = await page.place(10_060, 10_040);
      await page.page.mouse.move(x, y);
      await page.page.mouse.wheel({ deltaY: -300 });
      await page.ready();
    }
    const near = performance.now();
    const seen = await shot(page);
    const kinds = new Set();
    for (let y = 0; y < seen.height; y += 4) for (let x = 0; x < seen.width; x += 4) kinds.add(seen.at(x, y));
    assert.ok(
      [...kinds].some((c) => /^#ff[01]/.test(c)) && [...kinds].some((c) => /^#[01].[01].ff$/.test(c)),
      "walls and room",
    );
    assert.ok(canvas.width > 0);
    const times = [served - begun, shown - served, near - shown].map(Math.round);
    process.stderr.write(
      `measured: a map of 20000 × 20000: server ${times[0]} ms, first picture ${times[1]} ms, eight zooms ${times[2]} ms\n`,
    );
    assert.ok(shown - begun < 15_000 && near - shown < 20_000, `${times} ms`);
  });
  server.close();
});
