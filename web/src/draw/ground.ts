// The ground that a map lies on: hatched outside the grid, the grid's border; and its measure: ticks and a scale bar in
// metres.

import { type Brush, pixels } from "./brush";

export function drawOutside({ context, viewport, ratio, ink }: Brush): void {
  context.fillStyle = ink.outside;
  context.fillRect(0, 0, viewport.width, viewport.height);
  context.strokeStyle = ink.hatch;
  context.lineWidth = 1 / ratio;
  context.beginPath();
  for (let x = -viewport.height; x < viewport.width; x += 9) {
    context.moveTo(x, viewport.height);
    context.lineTo(x + viewport.height, 0);
  }
  context.stroke();
}

/** The grid's rectangle, as if nothing was reached. */
export function drawGround(brush: Brush, untouched: string): void {
  const { context, viewport } = brush;
  const box = pixels(brush, [0, 0], [viewport.grid.width, viewport.grid.height]);
  context.save();
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.fillStyle = untouched;
  context.fillRect(box.x, box.y, box.width, box.height);
  context.restore();
}

export function drawBorder(brush: Brush): void {
  const { context, viewport, ratio, ink } = brush;
  const box = pixels(brush, [0, 0], [viewport.grid.width, viewport.grid.height]);
  context.save();
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.strokeStyle = ink.border;
  context.lineWidth = ratio;
  context.strokeRect(box.x - ratio / 2, box.y - ratio / 2, box.width + ratio, box.height + ratio);
  context.restore();
}

/** The round length, 1, 2 or 5 times a power of ten, next to that one. */
export function round(length: number): number {
  const power = 10 ** Math.floor(Math.log10(length));
  const digit = length / power;
  return (digit < 1.5 ? 1 : digit < 3.5 ? 2 : digit < 7.5 ? 5 : 10) * power;
}

function label(
  brush: Brush,
  text: string,
  x: number,
  y: number,
  align: CanvasTextAlign,
  baseline: CanvasTextBaseline,
): void {
  const { context, ink } = brush;
  context.textAlign = align;
  context.textBaseline = baseline;
  context.lineJoin = "round";
  context.lineWidth = 3;
  context.strokeStyle = ink.halo;
  context.strokeText(text, x, y);
  context.fillStyle = ink.text;
  context.fillText(text, x, y);
}

const text = (value: number, step: number): string => value.toFixed(step < 1 ? Math.ceil(-Math.log10(step)) : 0);

/** Ticks in metres along the lower and the left edge, and a scale bar. */
export function drawAxes(brush: Brush): void {
  const { context, viewport, ink } = brush;
  const { grid, width, height } = viewport;
  const metre = viewport.scale / grid.resolution;
  const step = round(90 / metre);
  context.font = "11px system-ui, sans-serif";
  context.strokeStyle = ink.text;
  context.lineWidth = 1;
  const [left, top] = viewport.toCells(0, 0);
  const [right, bottom] = viewport.toCells(width, height);
  const ticks = (from: number, to: number, origin: number, draw: (value: number, cells: number) => void) => {
    const first = Math.ceil((origin + Math.min(from, to) * grid.resolution) / step);
    const last = Math.floor((origin + Math.max(from, to) * grid.resolution) / step);
    for (let k = first; k <= last; k++) draw(k * step, (k * step - origin) / grid.resolution);
  };
  ticks(left, right, grid.x0, (value, column) => {
    const x = viewport.toScreen([column, 0])[0];
    if (x < 40 || x > width - 150) return;
    context.fillStyle = ink.text;
    context.fillRect(x - 0.5, height - 5, 1, 5);
    label(brush, text(value, step), x, height - 7, "center", "bottom");
  });
  ticks(bottom, top, grid.y0, (value, row) => {
    const y = viewport.toScreen([0, row])[1];
    if (y < 12 || y > height - 28) return;
    context.fillStyle = ink.text;
    context.fillRect(0, y - 0.5, 5, 1);
    // On a plate: the grid's border may run through it.
    const wide = context.measureText(text(value, step)).width;
    context.fillStyle = ink.plate;
    context.fillRect(6, y - 8, wide + 4, 16);
    label(brush, text(value, step), 8, y, "left", "middle");
  });
  const bar = round(Math.min(100, width / 5) / metre);
  const long = bar * metre;
  const [x, y] = [width - 14 - long, height - 12];
  context.fillStyle = ink.halo;
  context.fillRect(x - 1.5, y - 1.5, long + 3, 7);
  context.fillStyle = ink.text;
  context.fillRect(x, y, long, 4);
  label(
    brush,
    bar < 0.01 ? `${Number((bar * 1000).toPrecision(1))} mm` : `${Number(bar.toPrecision(1))} m`,
    x + long / 2,
    y - 4,
    "center",
    "bottom",
  );
}
