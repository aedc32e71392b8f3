// The cells that one reading touched: marked thinly, or shaded by how much it says of them. Baked into a picture of one
// pixel a cell.

import type { Working, WorkingStep } from "../generated/protocol";
import { type Brush, pixels } from "./brush";

/** Cells a picture may have; a reading that spreads over more is drawn cell by cell. */
const LARGEST = 1 << 24;

type Colour = [number, number, number];
/** Of shades: interior, arc. */
const SHADES: [Colour, Colour] = [
  [37, 99, 235],
  [220, 38, 38],
];
/** Of marks over a map that is blue and red itself. */
const MARKS: [Colour, Colour] = [
  [13, 148, 136],
  [245, 158, 11],
];

interface Baked {
  working: Working;
  key: string;
  picture: HTMLCanvasElement;
  column: number;
  row: number;
}

const bakery = new Map<number, Baked>();

/** Where a later step of the evidence shades the arc: its largest, and what it is. */
export function strongestOf(working: Working, step: WorkingStep): { value: number; is: string } | null {
  const values = step === "own" ? undefined : working[step];
  if (!values || !working.steps.includes(step)) return null;
  const all = values.map((v, k) => (working.region[k] === 1 ? Math.abs(v ?? 0) : 0));
  return { value: all.reduce((a, b) => Math.max(a, b), 0), is: step };
}

/** How strong each cell's shade is: the server's own, or a later step of the evidence over its largest. */
function strengths(working: Working, step: WorkingStep): (number | null)[] {
  const values = step === "own" ? undefined : working[step];
  const largest = strongestOf(working, step)?.value;
  if (!values || largest === undefined) return working.strength;
  return working.strength.map((own, k) =>
    working.region[k] === 1 ? (largest > 0 ? Math.abs(values[k] ?? 0) / largest : 0) : own,
  );
}

function span(values: number[]): [number, number] {
  return values.reduce<[number, number]>(([a, b], v) => [Math.min(a, v), Math.max(b, v)], [Infinity, -Infinity]);
}

function bake(lane: number, working: Working, step: WorkingStep | "marks"): Baked | null {
  const known = bakery.get(lane);
  if (known?.working === working && known.key === step) return known;
  if (!working.column.length) return null;
  const [left, right] = span(working.column);
  const [bottom, top] = span(working.row);
  const [width, height] = [right - left + 1, top - bottom + 1];
  if (width * height > LARGEST) return null;
  const picture = document.createElement("canvas");
  picture.width = width;
  picture.height = height;
  const context = picture.getContext("2d");
  if (!context) return null;
  const image = context.createImageData(width, height);
  const strong = step === "marks" ? null : strengths(working, step);
  working.column.forEach((column, k) => {
    const row = working.row[k] ?? bottom;
    const at = 4 * ((top - row) * width + column - left);
    const colour = (strong ? SHADES : MARKS)[working.region[k] === 1 ? 1 : 0];
    image.data.set(colour, at);
    // A shade so faint that nobody sees it would hide that the cell was touched.
    const shade = strong ? 0.08 + 0.92 * Math.min(1, Math.max(0, strong[k] ?? 0)) : 0.4;
    image.data[at + 3] = Math.round(255 * shade);
  });
  context.putImageData(image, 0, 0);
  const baked = { working, key: step, picture, column: left, row: bottom };
  bakery.set(lane, baked);
  return baked;
}

/** Fills the cells, and borders them where they are large enough. */
export function drawCells(brush: Brush, lane: number, working: Working, step: WorkingStep | "marks"): void {
  const { context, viewport, ink } = brush;
  const baked = bake(lane, working, step);
  if (baked) {
    const { picture, column, row } = baked;
    const box = pixels(brush, [column, row], [column + picture.width, row + picture.height]);
    context.save();
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.imageSmoothingEnabled = box.width < picture.width;
    context.drawImage(picture, box.x, box.y, box.width, box.height);
    context.restore();
  }
  if (viewport.scale < 7) return;
  context.lineWidth = 1;
  const borders = step === "marks" ? [ink.markInterior, ink.markArc] : [ink.interior, ink.arc];
  working.column.forEach((column, k) => {
    const row = working.row[k] ?? 0;
    const [x, y] = viewport.toScreen([column, row + 1]);
    if (x < -viewport.scale || y < -viewport.scale || x > viewport.width || y > viewport.height) return;
    context.strokeStyle = borders[working.region[k] === 1 ? 1 : 0] ?? ink.border;
    context.strokeRect(x + 1, y + 1, viewport.scale - 2, viewport.scale - 2);
  });
}
