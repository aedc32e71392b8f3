// Pointers on a panel: drag to pan, wheel or two fingers to zoom, click to inspect a cell.

import type { Model } from "./model";
import type { CellPoint } from "./generated/protocol";

/** Pixels that a finger may slip in a click. */
const SLIP = 4;

export function listen(model: Model, canvas: HTMLCanvasElement): void {
  const down = new Map<number, CellPoint>();
  let moved = 0;
  const at = (e: MouseEvent): CellPoint => {
    const box = canvas.getBoundingClientRect();
    return [e.clientX - box.left, e.clientY - box.top];
  };
  const hover = (place: CellPoint | null) => {
    model.hover = place;
    model.tell("hover");
  };
  canvas.addEventListener("pointerdown", (e) => {
    if (e.button > 1) return;
    canvas.setPointerCapture(e.pointerId);
    down.set(e.pointerId, at(e));
    if (down.size === 1) moved = 0;
  });
  canvas.addEventListener("pointermove", (e) => {
    const [x, y] = at(e);
    const before = down.get(e.pointerId);
    if (!before) return hover(model.viewport.cellAt(x, y));
    const [dx, dy] = [x - before[0], y - before[1]];
    moved += Math.hypot(dx, dy);
    if (down.size === 1 && moved <= SLIP) return;
    const still = [...down].find(([id]) => id !== e.pointerId)?.[1];
    down.set(e.pointerId, [x, y]);
    if (!still) return model.viewport.pan(dx, dy);
    const [was, is] = [before, [x, y] as CellPoint].map((p) => Math.hypot(p[0] - still[0], p[1] - still[1])) as [
      number,
      number,
    ];
    model.viewport.zoom(is / Math.max(1, was), (x + still[0]) / 2, (y + still[1]) / 2);
    model.viewport.pan(dx / 2, dy / 2);
  });
  const up = (e: PointerEvent) => {
    const [x, y] = at(e);
    const clicked =
      e.type === "pointerup" && down.has(e.pointerId) && down.size === 1 && moved <= SLIP && e.button === 0;
    down.delete(e.pointerId);
    if (clicked) model.pick(model.viewport.cellAt(x, y));
  };
  canvas.addEventListener("pointerup", up);
  canvas.addEventListener("pointercancel", up);
  canvas.addEventListener("pointerleave", () => hover(null));
  canvas.addEventListener(
    "wheel",
    (e) => {
      e.preventDefault();
      const lines = e.deltaMode === WheelEvent.DOM_DELTA_LINE ? 30 : 1;
      const [x, y] = at(e);
      model.viewport.zoom(Math.exp(-Math.max(-300, Math.min(300, e.deltaY * lines)) * 0.0022), x, y);
      hover(model.viewport.cellAt(x, y));
    },
    { passive: false },
  );
}
