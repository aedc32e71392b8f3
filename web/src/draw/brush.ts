// What every drawing needs: the canvas, where it looks, and the page's colours.

import type { CellPoint } from "../generated/protocol";
import type { Viewport } from "../viewport";

/** The theme's colours, read from the style sheet. */
export interface Ink {
  outside: string;
  hatch: string;
  border: string;
  text: string;
  halo: string;
  /** Under text that must not be crossed. */
  plate: string;
  cone: string;
  robot: string;
  interior: string;
  arc: string;
  markInterior: string;
  markArc: string;
  picked: string;
  cursor: string;
}

export interface Brush {
  context: CanvasRenderingContext2D;
  viewport: Viewport;
  /** Pixels of the screen for a CSS pixel. */
  ratio: number;
  ink: Ink;
}

export function readInk(): Ink {
  const style = getComputedStyle(document.documentElement);
  const ink = (name: string) => style.getPropertyValue(`--${name}`).trim();
  return {
    outside: ink("outside"),
    hatch: ink("hatch"),
    border: ink("border"),
    text: ink("ink"),
    halo: ink("halo"),
    plate: ink("outside"),
    cone: ink("cone"),
    robot: ink("robot"),
    interior: ink("interior"),
    arc: ink("arc"),
    markInterior: ink("mark-interior"),
    markArc: ink("mark-arc"),
    picked: ink("picked"),
    cursor: ink("cursor"),
  };
}

/** Pixels of the screen from column to column, or row to row, rounded so that neighbours meet without a seam. */
export function pixels(brush: Brush, from: CellPoint, to: CellPoint): { x: number; y: number; width: number; height: number } {
  const { viewport, ratio } = brush;
  const [left, bottom] = viewport.toScreen(from);
  const [right, top] = viewport.toScreen(to);
  const x = Math.round(left * ratio);
  const y = Math.round(top * ratio);
  return { x, y, width: Math.round(right * ratio) - x, height: Math.round(bottom * ratio) - y };
}

/** A path through places. */
export function trace({ context, viewport }: Brush, places: CellPoint[], close = false): void {
  context.beginPath();
  places.forEach((place, k) => {
    const [x, y] = viewport.toScreen(place);
    if (k === 0) context.moveTo(x, y);
    else context.lineTo(x, y);
  });
  if (close) context.closePath();
}

/** Strokes the path twice, so that it is seen on any ground. */
export function stroke({ context, ink }: Brush, colour: string, width = 1.5): void {
  context.lineJoin = "round";
  context.lineWidth = width + 2;
  context.strokeStyle = ink.halo;
  context.stroke();
  context.lineWidth = width;
  context.strokeStyle = colour;
  context.stroke();
}
