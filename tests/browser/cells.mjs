// A cell: inspected by pointer and by keys, its state and its history.

import assert from "node:assert/strict";
import { test } from "node:test";
import { visit } from "./lib/page.mjs";
import { LOGS, serve } from "./lib/tool.mjs";

/** A cell on the arc of the latest reading with an echo. */
async function onArc(server) {
  for (let k = 0; k < 60; k++) {
    const told = await server.json("api/working?lane=0");
    const at = told.region.indexOf(1);
    if (at >= 0) return [told.column[at], told.row[at]];
    await server.json("api/go", { by: "reading", count: -1 });
  }
  throw new Error("no echo");
}

test("a click inspects the cell under it, and its history tells what each reading did", async () => {
  const server = await serve(LOGS.ring(), "-m", "bayes");
  await server.json("api/go", { to: 100 });
  const [column, row] = await onArc(server);
  await visit(server, async (page) => {
    await page.page.mouse.click(...(await page.place(column, row)));
    await page.ready();
    assert.deepEqual((await page.state()).picked, [column, row]);
    const cell = await server.json(`api/cell?column=${column}&row=${row}`);
    const told = await page.text("#cell");
    assert.match(told, new RegExp(`column, row\\s+${column}, ${row}`));
    assert.match(told, new RegExp(`x ${cell.x.toFixed(3)} m, y ${cell.y.toFixed(3)} m`));
    assert.match(told, new RegExp(`class\\s+${cell.sources[0].class}`));
    assert.match(told, new RegExp(`times on the arc\\s+${cell.sources[0].arc}`));
    for (const [name] of cell.sources[0].values) assert.ok(told.includes(name), name);
    await page.open("#history-details");
    const { total, events } = await server.json(`api/history?lane=0&column=${column}&row=${row}&count=100`);
    assert.equal(total, cell.sources[0].arc + cell.sources[0].interior);
    const rows = await page.page.$$eval("#history tbody tr", (all) => all.map((r) => r.cells[0].innerText));
    assert.deepEqual(
      rows,
      events.map((e) => String(e.number)),
    );
    // Evidence adds up: what one reading leaves is what the next one finds.
    events.slice(1).forEach((e, k) => assert.deepEqual(e.after, events[k].before));
    await page.key("Escape");
    assert.equal((await page.state()).picked, null);
  });
  server.close();
});

test("keys alone find a cell and inspect it", async () => {
  const server = await serve(LOGS.ring(), "-m", "certainty");
  await visit(server, async (page) => {
    await page.key("End", "c");
    const [column, row] = (await page.state()).viewport.centre.map(Math.floor);
    await page.key("ArrowRight", "ArrowRight", "ArrowUp", "Shift+ArrowLeft", "Enter");
    assert.deepEqual((await page.state()).picked, [column + 2 - 10, row + 1]);
    assert.match(await page.text("#hover"), new RegExp(`column ${column - 8}, row ${row + 1}`));
    await page.key("Escape", "ArrowLeft");
    const { position, total } = (await page.state()).state;
    assert.equal(position, total - 1, "without the cursor arrows are steps again");
  });
  server.close();
});

test("under the pointer: metres, cell, and what the reading says of it", async () => {
  const server = await serve(LOGS.ring(), "-m", "certainty");
  await server.json("api/go", { to: 100 });
  const [column, row] = await onArc(server);
  await visit(server, async (page) => {
    await page.page.mouse.move(...(await page.place(column, row)));
    await page.ready();
    const { x0, y0, resolution } = (await server.json("api/session")).grid;
    const [x, y] = [x0 + (column + 0.5) * resolution, y0 + (row + 0.5) * resolution].map((v) => v.toFixed(3));
    assert.ok((await page.text("#hover")).startsWith(`x ${x} m, y ${y} m · column ${column}, row ${row} · arc, own `));
  });
  server.close();
});

test("of a counting sensor model the chosen poses are listed", async () => {
  const server = await serve(LOGS.ring(), "-m", "csm-continuous");
  await visit(server, async (page) => {
    await page.key("End");
    const {
      robot_cell: [column, row],
    } = (await page.state()).state.lanes[0].current;
    await page.page.mouse.click(...(await page.place(Math.floor(column) + 3, Math.floor(row))));
    await page.ready();
    assert.match(await page.text("#cell"), /chosen poses and beams/);
    assert.ok((await page.state()).cell.sources[0].chosen.length > 0);
  });
  server.close();
});
