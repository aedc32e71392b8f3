// What `echogrid map` makes of the same log, up to a reading.

import { readFileSync } from "node:fs";
import { join } from "node:path";
import { decode } from "./png.mjs";
import { fromBottom } from "./tiles.mjs";
import { map } from "./tool.mjs";

const UNTOUCHED = "#a8b4c4";
let count = 0;

/** A layer's picture after so many readings, laid on the grid that the page has. */
export async function mapped(server, log, method, { until, name = "map", set = [] } = {}) {
  const more = [...(until === undefined ? [] : ["--until", String(until)]), ...set.flatMap((s) => ["--set", s])];
  const folder = map(`like-${count++}`, log, "-m", method, ...more);
  const own = fromBottom(decode(readFileSync(join(folder, `${name}.png`))));
  const { grid } = await server.json("api/session");
  const [x0, y0] = /origin: \[([^,]+), ([^,]+)/
    .exec(readFileSync(join(folder, "map.yaml"), "utf8"))
    .slice(1)
    .map(Number);
  // Fewer readings may need fewer cells.
  const [right, up] = [(x0 - grid.x0) / grid.resolution, (y0 - grid.y0) / grid.resolution].map(Math.round);
  const at = (column, row) => {
    const [c, r] = [column - right, row - up];
    return c >= 0 && r >= 0 && c < own.width && r < own.height ? own.at(c, r) : UNTOUCHED;
  };
  return { width: grid.width, height: grid.height, at };
}
