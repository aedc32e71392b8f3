// Saving: the file's pixels are the canvas's, and the cells' colours are the map's.

import assert from "node:assert/strict";
import { mkdirSync, readdirSync, readFileSync } from "node:fs";
import { test } from "node:test";
import { join } from "node:path";
import { visit } from "./lib/page.mjs";
import { onCells, shot } from "./lib/shot.mjs";
import { picture } from "./lib/tiles.mjs";
import { LOGS, inside, serve } from "./lib/tool.mjs";

test("the saved picture is what the panel shows", async () => {
  const server = await serve(LOGS.ring(), "-m", "certainty");
  const downloadPath = inside("saved");
  mkdirSync(downloadPath);
  await visit(
    server,
    async (page) => {
      const devtools = await page.page.createCDPSession();
      await devtools.send("Browser.setDownloadBehavior", { behavior: "allow", downloadPath });
      await page.key("End", "m", "o");
      await page.click("#axes");
      await page.click("#save");
      const { total } = (await page.state()).state;
      const name = `cartons-ring8-20.jsonl-certainty-combined-${total}.png`;
      await waitFor(() => readdirSync(downloadPath).includes(name), name);
      const bytes = readFileSync(join(downloadPath, name));
      const [saved, canvas] = [await onCells(page, bytes), await shot(page)];
      assert.deepEqual([saved.width, saved.height], [canvas.width, canvas.height]);
      for (let y = 0; y < saved.height; y += 3) {
        for (let x = 0; x < saved.width; x += 3) assert.equal(saved.at(x, y), canvas.at(x, y), `pixel ${x}, ${y}`);
      }
      const own = await picture(server, "combined");
      for (let row = 1; row < own.height; row += 3) {
        for (let column = 1; column < own.width; column += 3) {
          assert.equal(saved.cell(column, row), own.at(column, row), `cell ${column}, ${row}`);
        }
      }
    },
    { ratio: 2 },
  );
  server.close();
});

async function waitFor(test, what) {
  for (let k = 0; k < 100; k++) {
    if (test()) return;
    await new Promise((next) => setTimeout(next, 50));
  }
  throw new Error(`no ${what}`);
}
