// All of a view as one picture, from its tiles of level 0.

import { decode } from "./png.mjs";

const EDGE = 256;

/** The colour of a cell, row 0 at the bottom, in a view of a source. */
export async function picture(server, view, source = 0, more = "") {
  const { grid, sources, difference } = await server.json("api/session");
  const { legend } = source === "difference" ? difference : sources[source].views.find((v) => v.name === view);
  const tiles = new Map();
  for (let row = 0; row * EDGE < grid.height; row++) {
    for (let column = 0; column * EDGE < grid.width; column++) {
      const path = `api/tile?source=${source}&view=${view}&level=0&column=${column}&row=${row}${more}`;
      const answer = await server.ask(path);
      if (answer.status !== 204) tiles.set(`${column},${row}`, decode(Buffer.from(await answer.arrayBuffer())));
    }
  }
  const at = (column, row) => {
    const tile = tiles.get(`${Math.floor(column / EDGE)},${Math.floor(row / EDGE)}`);
    return tile ? tile.at(column % EDGE, tile.height - 1 - (row % EDGE)) : legend.untouched;
  };
  return { width: grid.width, height: grid.height, at };
}

/** A map's picture, its rows counted from the bottom too. */
export function fromBottom({ width, height, at }) {
  return { width, height, at: (column, row) => at(column, height - 1 - row) };
}

/** Cells whose colours differ; every `step`th row and column is looked at. */
export function differences(a, b, step = 1) {
  if (a.width !== b.width || a.height !== b.height) return Infinity;
  let count = 0;
  for (let row = 0; row < a.height; row += step) {
    for (let column = 0; column < a.width; column += step) count += a.at(column, row) !== b.at(column, row);
  }
  return count;
}

/** How many colours a picture has: a test on an empty one would prove nothing. */
export function colours({ width, height, at }) {
  const found = new Set();
  for (let row = 0; row < height; row++) for (let column = 0; column < width; column++) found.add(at(column, row));
  return found.size;
}
