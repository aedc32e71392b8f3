// The reading, or the scan, that was applied last: the robot, the cone's outline, what a feature made of it, the beams.

import type { CellPoint, ChosenBeam, Current, CurrentReading, FeatureCase, WorldPose } from "../generated/protocol";
import { type Brush, stroke, trace } from "./brush";

export function drawCurrent(brush: Brush, current: Current): void {
  if (current.kind === "reading") {
    if (current.case) drawCase(brush, current.case, current);
    drawOutline(brush, current);
  } else {
    drawBeams(
      brush,
      current.beams.map((b) => ({ ray: b.ray, faint: b.range === null })),
    );
  }
  drawRobot(brush, current.robot);
}

function drawOutline(brush: Brush, { outline }: CurrentReading): void {
  if (!outline) return;
  const { context, viewport, ink } = brush;
  for (const line of outline.lines) {
    trace(brush, line);
    stroke(brush, ink.cone);
  }
  context.setLineDash([5, 4]);
  trace(brush, outline.axis);
  stroke(brush, ink.cone, 1);
  context.setLineDash([]);
  const [x, y] = viewport.toScreen(outline.sensor);
  context.beginPath();
  context.arc(x, y, 3, 0, 2 * Math.PI);
  stroke(brush, ink.cone, 1);
  context.fillStyle = ink.cone;
  context.fill();
}

/** A fan: from the sensor over the places and back to it. */
function fan(brush: Brush, sensor: CellPoint, places: CellPoint[]): void {
  trace(brush, [sensor, ...places], true);
}

function drawCase(brush: Brush, made: FeatureCase, reading: CurrentReading): void {
  const { context, viewport, ink } = brush;
  const sensor = reading.outline?.sensor ?? viewport.fromWorld(reading.pose[0], reading.pose[1]);
  const fill = (places: CellPoint[], colour: string, weight: number) => {
    fan(brush, sensor, places);
    context.globalAlpha = 0.15 + 0.3 * weight;
    context.fillStyle = colour;
    context.fill();
    context.globalAlpha = 1;
  };
  if (made.routine) {
    const { free, arc, weight } = made.routine;
    context.setLineDash([3, 3]);
    for (const [places, colour] of [
      [free, ink.interior],
      [arc, ink.arc],
    ] as const) {
      if (!places) continue;
      fill(places, colour, 0.4 * weight);
      fan(brush, sensor, places);
      stroke(brush, colour, 1);
    }
    context.setLineDash([]);
  }
  for (const part of made.parts) {
    if (part.free) fill(part.free, ink.interior, part.weight);
    for (const line of part.occupied) {
      trace(brush, line);
      stroke(brush, ink.arc, 2 + 2 * part.weight);
    }
  }
}

function drawBeams(brush: Brush, beams: { ray: [CellPoint, CellPoint]; faint: boolean }[]): void {
  const { context, viewport, ink } = brush;
  context.lineWidth = 1;
  for (const { ray, faint } of beams) {
    context.globalAlpha = faint ? 0.2 : 0.6;
    context.strokeStyle = ink.cone;
    trace(brush, ray);
    context.stroke();
    if (faint) continue;
    const [x, y] = viewport.toScreen(ray[1]);
    context.fillStyle = ink.arc;
    context.globalAlpha = 0.9;
    context.fillRect(x - 1.5, y - 1.5, 3, 3);
  }
  context.globalAlpha = 1;
}

/** The poses and the beams that speak of the inspected cell. */
export function drawChosen(brush: Brush, chosen: ChosenBeam[]): void {
  const { context, viewport, ink } = brush;
  for (const { pose, ray } of chosen) {
    if (ray) {
      trace(brush, ray);
      stroke(brush, ink.picked, 1);
    }
    const at = pose ? viewport.fromWorld(pose[0], pose[1]) : ray?.[0];
    if (!at) continue;
    const [x, y] = viewport.toScreen(at);
    context.beginPath();
    context.arc(x, y, 4, 0, 2 * Math.PI);
    stroke(brush, ink.picked, 1.5);
  }
}

/** A disc of 0.2 m, but never too small to see, and where it heads. */
function drawRobot(brush: Brush, [x, y, heading]: WorldPose): void {
  const { context, viewport, ink } = brush;
  const [px, py] = viewport.toScreen(viewport.fromWorld(x, y));
  const radius = Math.max(6, (0.2 * viewport.scale) / viewport.grid.resolution);
  context.beginPath();
  context.arc(px, py, radius, 0, 2 * Math.PI);
  context.globalAlpha = 0.35;
  context.fillStyle = ink.robot;
  context.fill();
  context.globalAlpha = 1;
  stroke(brush, ink.robot, 2);
  const at = (angle: number, reach: number): [number, number] => [
    px + reach * radius * Math.cos(heading + angle),
    py - reach * radius * Math.sin(heading + angle),
  ];
  context.beginPath();
  context.moveTo(...at(0, 1.5));
  context.lineTo(...at(2.5, 0.7));
  context.lineTo(...at(-2.5, 0.7));
  context.closePath();
  context.fillStyle = ink.robot;
  context.fill();
}
