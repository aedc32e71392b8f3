// The side panel of the current reading: its numbers, and a table of the cells that it touched.

import { byId, make, pairs } from "./dom";
import { change, count, degrees, metres, number, seconds } from "./format";
import type { Model } from "./model";
import type { Current, Working } from "./generated/protocol";

/** Rows of the table at first, and more of them at a time. */
const ROWS = 200;

type Column = {
  name: string;
  value: (w: Working, k: number) => number | string | null;
  text?: (w: Working, k: number) => string;
};

const COLUMNS: Column[] = [
  {
    name: "cell",
    value: (w, k) => (w.row[k] ?? 0) * 1e6 + (w.column[k] ?? 0),
    text: (w, k) => `${w.column[k]}, ${w.row[k]}`,
  },
  { name: "where", value: (w, k) => (w.region[k] === 1 ? "arc" : "interior") },
  { name: "own", value: (w, k) => w.own[k] ?? null },
  { name: "cancelled", value: (w, k) => w.cancelled?.[k] ?? null },
  { name: "normalised", value: (w, k) => w.normalised?.[k] ?? null },
  {
    name: "before → after",
    value: (w, k) =>
      w.layers.reduce((sum, _, n) => sum + Math.abs((w.after[n]?.[k] ?? 0) - (w.before[n]?.[k] ?? 0)), 0),
    text: (w, k) =>
      change(
        w.layers,
        w.layers.map((_, n) => w.before[n]?.[k] ?? null),
        w.layers.map((_, n) => w.after[n]?.[k] ?? null),
      ),
  },
  { name: "d, m", value: (w, k) => w.d[k] ?? null },
  { name: "θ", value: (w, k) => w.theta[k] ?? null, text: (w, k) => degrees(w.theta[k]) },
];

/** Why a reading shows less than one would expect; "" where it does not. */
export function nothing(current: Current, working: Working | null): string {
  if (!working || current.kind !== "reading") return "";
  if (working.interior + working.arc === 0) {
    return current.case ? "It reaches no cell." : "Outside the grid: it reaches no cell.";
  }
  const echo = current.outcome === "hit" && !current.case;
  return echo && working.arc === 0 ? "No cell on its arc." : "";
}

export class ReadingPanel {
  private readonly box = byId("reading", HTMLDivElement);
  private readonly details = byId("reading-details", HTMLDetailsElement);
  private sort = "own";
  private down = true;
  private rows = ROWS;

  constructor(private readonly model: Model) {
    model.on(["session", "state", "working"], () => this.refresh());
    this.details.addEventListener("toggle", () => this.refresh());
    this.refresh();
  }

  get open(): boolean {
    return this.details.open;
  }

  private refresh(): void {
    if (!this.open) return;
    const parts = this.model.session.sources.flatMap((source, k) => {
      const current = this.model.lane(k)?.current;
      const working = this.model.workings[k] ?? null;
      const head = this.model.session.sources.length > 1 ? [make("h3", {}, source.name)] : [];
      if (!current) return [...head, make("p", {}, "At the start: no reading yet. → takes one.")];
      return [
        ...head,
        this.numbers(current, working),
        ...this.cases(current),
        ...[nothing(current, working)].filter((text) => text !== "").map((text) => make("p", { class: "nothing" }, text)),
        ...(working?.column.length ? [this.cells(working, k)] : []),
      ];
    });
    this.box.replaceChildren(...parts);
  }

  private numbers(current: Current, working: Working | null): HTMLElement {
    const entries: [string, string][] = [
      ["number", count(current.number)],
      ["line of the log", count(current.line)],
      ["scan", `${count(this.model.state?.scan ?? 0)} (id ${current.scan} in the log)`],
      ["time", seconds(current.t)],
    ];
    if (current.kind === "reading") {
      entries.push(
        ["sensor", current.sensor],
        ["outcome", current.outcome === "hit" ? "echo" : "no echo"],
        ["range", metres(current.range)],
        ["half width", degrees(current.half_width)],
      );
    } else {
      entries.push(
        ["beams", count(current.beams.length)],
        ["with a hit", count(current.beams.filter((b) => b.range !== null).length)],
      );
    }
    entries.push(["robot", `${number(current.robot[0])}, ${number(current.robot[1])} m, ${degrees(current.robot[2])}`]);
    if (working) {
      entries.push(["interior cells", count(working.interior)], ["arc cells", count(working.arc)]);
      if (working.n !== null && working.n !== undefined) entries.push(["n", count(working.n)]);
      if (working.sum !== null) entries.push(["Σ", number(working.sum)]);
      entries.push(["own is", working.own_is]);
    }
    return pairs(entries);
  }

  /** What features made of the reading. */
  private cases(current: Current): HTMLElement[] {
    if (current.kind !== "reading" || !current.case) return [];
    const { name, about, parts, routine } = current.case;
    const entries: [string, string][] = [["case", `${name}: ${about}`]];
    for (const part of parts) entries.push([`associated to a ${part.feature}`, `weight ${number(part.weight)}`]);
    if (routine) {
      const limits = [
        routine.free ? "freed part limited" : "",
        routine.arc ? "arc limited" : "",
        routine.occupies ? "" : "occupies nothing",
      ];
      entries.push(["routine", [`weight ${number(routine.weight)}`, ...limits.filter(Boolean)].join(", ")]);
    }
    return [pairs(entries)];
  }

  private cells(working: Working, lane: number): HTMLElement {
    const columns = COLUMNS.filter(
      (c) => !(c.name === "cancelled" && !working.cancelled) && !(c.name === "normalised" && !working.normalised),
    );
    const by = columns.find((c) => c.name === this.sort) ?? columns[0];
    const order = working.column.map((_, k) => k);
    const key = order.map((k) => by?.value(working, k) ?? null);
    order.sort((a, b) => this.compare(key[a] ?? null, key[b] ?? null));
    const head = columns.map((c) => {
      const sorted = c.name === by?.name;
      const button = make("button", { type: "button" }, c.name, sorted ? (this.down ? " ↓" : " ↑") : "");
      button.addEventListener("click", () => this.sortBy(c.name, lane));
      return make(
        "th",
        {
          scope: "col",
          "data-column": c.name,
          "aria-sort": sorted ? (this.down ? "descending" : "ascending") : undefined,
        },
        button,
      );
    });
    const body = make("tbody");
    for (const k of order.slice(0, this.rows)) {
      const row = make("tr", { class: working.region[k] === 1 ? "arc" : "interior" });
      for (const column of columns) {
        const value = column.text?.(working, k) ?? number(column.value(working, k));
        row.append(make("td", {}, column.name === "cell" ? this.cell(working, k, value) : value));
      }
      body.append(row);
    }
    const rest = order.length - this.rows;
    const caption = `${count(order.length)} cells${working.truncated ? " (of more: only these are listed)" : ""}`;
    const made = make(
      "table",
      { class: "cells" },
      make("caption", {}, caption),
      make("thead", {}, make("tr", {}, ...head)),
      body,
    );
    const box = make(
      "div",
      { class: "scroll tall", tabindex: 0, role: "region", "aria-label": "touched cells", "data-lane": lane },
      made,
    );
    if (rest > 0) {
      const more = make("button", { type: "button" }, `more (${count(rest)})`);
      more.addEventListener("click", () => {
        this.rows += 5 * ROWS;
        this.refresh();
      });
      box.append(more);
    }
    return box;
  }

  private cell(working: Working, k: number, text: string): HTMLElement {
    const button = make("button", { type: "button", class: "link", title: "inspect this cell" }, text);
    button.addEventListener("click", () => {
      const place: [number, number] = [working.column[k] ?? 0, working.row[k] ?? 0];
      this.model.pick(place);
      this.model.viewport.show(place);
    });
    return button;
  }

  private compare(a: number | string | null, b: number | string | null): number {
    // What has no value comes last, whichever way it is sorted.
    if (a === null || b === null) return a === b ? 0 : a === null ? 1 : -1;
    const order = typeof a === "string" ? a.localeCompare(String(b)) : a - Number(b);
    return this.down ? -order : order;
  }

  private sortBy(name: string, lane: number): void {
    this.down = this.sort === name ? !this.down : true;
    this.sort = name;
    this.rows = ROWS;
    this.refresh();
    // The table is new: the focus goes back to the button that was pressed.
    this.box.querySelector<HTMLElement>(`[data-lane="${lane}"] [data-column="${name}"] button`)?.focus();
  }
}
