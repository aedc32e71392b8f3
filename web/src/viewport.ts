// Which part of the grid is on screen. One for all panels, so that they stay locked together.

import type { CellPoint, Grid } from "./generated/protocol";

/** CSS pixels a cell, at most. */
const NEAREST = 96;

export class Viewport {
  /** What stands in the middle, cells. */
  centre: CellPoint = [0, 0];
  /** CSS pixels a cell. */
  scale = 1;
  /** CSS pixels of a panel. */
  width = 1;
  height = 1;
  private fitted = true;

  constructor(
    public grid: Grid,
    private readonly moved: () => void,
  ) {}

  /** The scale at which all of the grid is seen. */
  get whole(): number {
    return Math.min(this.width / this.grid.width, this.height / this.grid.height) * 0.94;
  }

  fit(): void {
    this.fitted = true;
    this.scale = Math.min(NEAREST, this.whole);
    this.centre = [this.grid.width / 2, this.grid.height / 2];
    this.moved();
  }

  /** A panel's size changed: what was seen whole stays so. */
  resize(width: number, height: number): void {
    if (width === this.width && height === this.height) return;
    this.width = Math.max(1, width);
    this.height = Math.max(1, height);
    if (this.fitted) this.fit();
    else this.moved();
  }

  /** Another grid: the same place of the world stays in the middle. */
  regrid(grid: Grid): void {
    const old = this.grid;
    this.grid = grid;
    const same = (["x0", "y0", "resolution", "width", "height"] as const).every((k) => old[k] === grid[k]);
    if (same) return;
    if (this.fitted) return this.fit();
    const x = old.x0 + this.centre[0] * old.resolution;
    const y = old.y0 + this.centre[1] * old.resolution;
    this.centre = [(x - grid.x0) / grid.resolution, (y - grid.y0) / grid.resolution];
    this.scale *= grid.resolution / old.resolution;
    this.moved();
  }

  /** From cells to pixels of a panel, y down. */
  toScreen([column, row]: CellPoint): CellPoint {
    return [
      this.width / 2 + (column - this.centre[0]) * this.scale,
      this.height / 2 - (row - this.centre[1]) * this.scale,
    ];
  }

  /** From pixels of a panel to cells. */
  toCells(x: number, y: number): CellPoint {
    return [this.centre[0] + (x - this.width / 2) / this.scale, this.centre[1] - (y - this.height / 2) / this.scale];
  }

  /** Moves what is seen by that many pixels. */
  pan(dx: number, dy: number): void {
    this.fitted = false;
    this.look([this.centre[0] - dx / this.scale, this.centre[1] + dy / this.scale]);
  }

  /** Puts a place into the middle; the grid never leaves the screen. */
  look([column, row]: CellPoint): void {
    const within = (value: number, end: number) => Math.min(Math.max(value, 0), end);
    this.centre = [within(column, this.grid.width), within(row, this.grid.height)];
    this.moved();
  }

  /** Zooms by a factor; what lies at (x, y) stays there. */
  zoom(factor: number, x = this.width / 2, y = this.height / 2): void {
    const scale = Math.min(NEAREST, Math.max(Math.min(this.whole / 2, 1), this.scale * factor));
    if (scale === this.scale) return;
    const [column, row] = this.toCells(x, y);
    this.fitted = false;
    this.scale = scale;
    this.look([column - (x - this.width / 2) / scale, row + (y - this.height / 2) / scale]);
  }

  /** Moves just so far that the place is seen, with some room around it. */
  show(place: CellPoint): void {
    const [x, y] = this.toScreen(place);
    const room = Math.min(this.width, this.height) * 0.15;
    if (x < room || y < room || x > this.width - room || y > this.height - room) {
      this.fitted = false;
      this.look(place);
    }
  }

  /** The cell at a pixel of a panel; `null` outside the grid. */
  cellAt(x: number, y: number): CellPoint | null {
    const [column, row] = this.toCells(x, y).map(Math.floor) as CellPoint;
    const inside = column >= 0 && row >= 0 && column < this.grid.width && row < this.grid.height;
    return inside ? [column, row] : null;
  }

  /** From metres to cells. */
  fromWorld(x: number, y: number): CellPoint {
    return [(x - this.grid.x0) / this.grid.resolution, (y - this.grid.y0) / this.grid.resolution];
  }
}
