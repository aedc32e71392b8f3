// The line below the panels: metres and cell under the pointer, or under the cursor that keys move, and what is known
// there.

import { api } from "./api";
import { byId } from "./dom";
import { number } from "./format";
import type { Model } from "./model";
import type { Cell, CellPoint } from "./generated/protocol";

export class Hover {
  private readonly line = byId("hover", HTMLOutputElement);
  private fetching: AbortController | null = null;
  private timer = 0;
  /** Of each lane, the place of a cell among those that the current reading touched. */
  private touched: Map<number, number>[] = [];

  constructor(private readonly model: Model) {
    model.on(["hover"], () => this.refresh());
    model.on(["working"], () => {
      this.touched = [];
      this.refresh();
    });
    this.refresh();
  }

  /** Metres and cell, in words. */
  where([column, row]: CellPoint): string {
    const { x0, y0, resolution } = this.model.session.grid;
    const metres = (origin: number, k: number) => (origin + (k + 0.5) * resolution).toFixed(3);
    return `x ${metres(x0, column)} m, y ${metres(y0, row)} m · column ${column}, row ${row}`;
  }

  private refresh(): void {
    const place = this.model.hover ?? this.model.cursor;
    clearTimeout(this.timer);
    this.fetching?.abort();
    if (!place) {
      this.line.value = "Point at a cell, or press C to move to one by keys.";
      return;
    }
    this.line.value = `${this.where(place)}${this.says(place)}`;
    if (this.model.log) return;
    this.timer = window.setTimeout(() => void this.fetch(place), 40);
  }

  /** What the current reading says of a cell. */
  private says([column, row]: CellPoint): string {
    const parts = this.model.workings.map((working, lane) => {
      if (!working) return "";
      const key = (c: number, r: number) => r * this.model.session.grid.width + c;
      this.touched[lane] ??= new Map(working.column.map((c, k) => [key(c, working.row[k] ?? 0), k]));
      const k = this.touched[lane].get(key(column, row));
      if (k === undefined) return "";
      return ` · ${working.region[k] === 1 ? "arc" : "interior"}, own ${number(working.own[k])}`;
    });
    return [...new Set(parts)].join("");
  }

  private async fetch(place: CellPoint): Promise<void> {
    const fetching = new AbortController();
    this.fetching = fetching;
    try {
      const cell = await api.cell(...place, fetching.signal);
      if (!fetching.signal.aborted) this.line.value = `${this.where(place)} · ${values(cell)}`;
    } catch {
      // The pointer is elsewhere by now, or the server said no: metres and cell stay.
    }
  }
}

function values(cell: Cell): string {
  return cell.sources
    .map(
      (s) =>
        `${s.name}: ${s.touched ? [s.class, ...s.values.map(([n, v]) => `${n} ${number(v)}`)].join(", ") : "not reached"}`,
    )
    .join(" · ");
}
