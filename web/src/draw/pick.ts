// The inspected cell, and the one that keys move.

import type { CellPoint } from "../generated/protocol";
import type { Brush } from "./brush";

export function drawPick(brush: Brush, [column, row]: CellPoint, kind: "picked" | "cursor"): void {
  const { context, viewport, ink } = brush;
  const [x, y] = viewport.toScreen([column + 0.5, row + 0.5]);
  const half = Math.max(viewport.scale / 2, 4) + 1.5;
  context.strokeStyle = ink.halo;
  context.lineWidth = 4;
  context.strokeRect(x - half, y - half, 2 * half, 2 * half);
  context.strokeStyle = ink[kind];
  context.lineWidth = 2;
  context.setLineDash(kind === "cursor" ? [4, 2] : []);
  context.strokeRect(x - half, y - half, 2 * half, 2 * half);
  context.setLineDash([]);
  if (kind !== "cursor") return;
  context.beginPath();
  for (const [dx, dy] of [
    [1, 0],
    [-1, 0],
    [0, 1],
    [0, -1],
  ] as CellPoint[]) {
    context.moveTo(x + dx * (half + 3), y + dy * (half + 3));
    context.lineTo(x + dx * (half + 10), y + dy * (half + 10));
  }
  context.stroke();
}
