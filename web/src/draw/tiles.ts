// A source's tiles on a panel: the level that suits the zoom, and while its tiles load what coarser or finer ones show
// of it.

import type { CellPoint } from "../generated/protocol";
import { EDGE, type SourceId, type Tiles } from "../tiles";
import { type Brush, pixels } from "./brush";

export interface Layer {
  source: SourceId;
  view: string;
  untouched: string;
  opacity: number;
}

/** The level whose pixel comes closest to one of the screen's. */
export function levelFor(scale: number, levels: number): number {
  return Math.max(0, Math.min(levels - 1, Math.round(Math.log2(1 / scale))));
}

/** Draws a layer, and asks for the tiles that it lacks, those in the middle first. */
export function drawTiles(brush: Brush, tiles: Tiles, levels: number, layer: Layer): void {
  const { context, viewport, ratio } = brush;
  const level = levelFor(viewport.scale * ratio, levels);
  const span = EDGE * 2 ** level;
  const { width, height } = viewport.grid;
  const [left, top] = viewport.toCells(0, 0);
  const [right, bottom] = viewport.toCells(viewport.width, viewport.height);
  const places: CellPoint[] = [];
  for (let c = Math.max(0, Math.floor(left / span)); c * span < Math.min(right, width); c++) {
    for (let r = Math.max(0, Math.floor(bottom / span)); r * span < Math.min(top, height); r++) places.push([c, r]);
  }
  const far = ([c, r]: CellPoint) =>
    Math.hypot((c + 0.5) * span - viewport.centre[0], (r + 0.5) * span - viewport.centre[1]);
  places.sort((a, b) => far(a) - far(b));

  context.save();
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.globalAlpha = layer.opacity;
  clipToGrid(brush);
  for (const [c, r] of places) {
    const picture = tiles.want(layer.source, layer.view, level, c, r);
    if (picture) put(brush, picture, level, c, r);
    else if (picture === null) ground(brush, layer, level, c, r);
    else standIn(brush, tiles, levels, layer, level, c, r);
  }
  context.restore();
}

function clipToGrid(brush: Brush): void {
  const { grid } = brush.viewport;
  const box = pixels(brush, [0, 0], [grid.width, grid.height]);
  brush.context.beginPath();
  brush.context.rect(box.x, box.y, box.width, box.height);
  brush.context.clip();
}

/** A tile's box; its picture may be smaller than a whole tile. */
function boxOf(brush: Brush, level: number, c: number, r: number, width = EDGE, height = EDGE) {
  const cells = 2 ** level;
  const from: CellPoint = [c * EDGE * cells, r * EDGE * cells];
  return pixels(brush, from, [from[0] + width * cells, from[1] + height * cells]);
}

function put(brush: Brush, picture: ImageBitmap, level: number, c: number, r: number): void {
  const box = boxOf(brush, level, c, r, picture.width, picture.height);
  // Reduced, neighbours mix, so that no thin wall is skipped; magnified, cells stay squares.
  brush.context.imageSmoothingEnabled = box.width < picture.width;
  brush.context.drawImage(picture, box.x, box.y, box.width, box.height);
}

function ground(brush: Brush, layer: Layer, level: number, c: number, r: number): void {
  const box = boxOf(brush, level, c, r);
  brush.context.fillStyle = layer.untouched;
  brush.context.fillRect(box.x, box.y, box.width, box.height);
}

/** What is known of a tile that is still to come. */
function standIn(brush: Brush, tiles: Tiles, levels: number, layer: Layer, level: number, c: number, r: number): void {
  const { context } = brush;
  const box = boxOf(brush, level, c, r);
  context.save();
  context.beginPath();
  context.rect(box.x, box.y, box.width, box.height);
  context.clip();
  for (let above = level + 1; above < levels; above++) {
    const [ac, ar] = [c >> (above - level), r >> (above - level)];
    const picture = tiles.peek(layer.source, layer.view, above, ac, ar);
    if (picture === undefined) continue;
    if (picture) put(brush, picture, above, ac, ar);
    else ground(brush, layer, above, ac, ar);
    break;
  }
  if (level > 0) {
    for (const [dc, dr] of [
      [0, 0],
      [1, 0],
      [0, 1],
      [1, 1],
    ] as CellPoint[]) {
      const picture = tiles.peek(layer.source, layer.view, level - 1, 2 * c + dc, 2 * r + dr);
      if (picture) put(brush, picture, level - 1, 2 * c + dc, 2 * r + dr);
    }
  }
  context.restore();
}
