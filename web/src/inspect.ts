// The inspected cell: its state in every source, and the readings that touched it with what each did.

import { api } from "./api";
import { byId, make, pairs, table } from "./dom";
import { change, count, metres, number, seconds } from "./format";
import type { Model } from "./model";
import type { CellSource, ChosenBeam, History, HistoryEvent, Json } from "./generated/protocol";

const FIRST = 100;

export class Inspect {
  private readonly box = byId("cell", HTMLDivElement);
  private readonly past = byId("history", HTMLDivElement);
  private readonly details = byId("history-details", HTMLDetailsElement);
  private readonly lane = byId("history-lane", HTMLSelectElement);
  private running = false;
  private again = false;
  private many = FIRST;

  constructor(
    private readonly model: Model,
    private readonly failed: (why: string) => void,
  ) {
    this.details.hidden = !model.log;
    model.on(["pick"], () => {
      this.many = FIRST;
      void this.refresh();
    });
    model.on(["session", "state", "compute"], () => void this.refresh());
    model.on(["session"], () => this.lanes());
    this.details.addEventListener("toggle", () => void this.refresh());
    this.lane.addEventListener("change", () => void this.refresh());
    this.lanes();
    this.show();
  }

  private lanes(): void {
    const { sources } = this.model.session;
    const kept = this.lane.value;
    this.lane.replaceChildren(...sources.map((s, k) => make("option", { value: k }, s.name)));
    this.lane.value = Number(kept) < sources.length && kept ? kept : "0";
    byId("history-lane-field", HTMLLabelElement).hidden = sources.length < 2;
  }

  /** Asks anew, one question at a time, the newest last. */
  private async refresh(): Promise<void> {
    if (this.running) {
      this.again = true;
      return;
    }
    this.running = true;
    try {
      do {
        this.again = false;
        await this.fetch();
      } while (this.again);
    } catch (e) {
      this.failed(e instanceof Error ? e.message : String(e));
    } finally {
      this.running = false;
    }
  }

  private async fetch(): Promise<void> {
    const { model } = this;
    const place = model.picked;
    if (!place) return this.show();
    const cell = await api.cell(...place);
    if (model.picked !== place) return;
    model.cell = cell;
    model.tell("cell");
    this.show();
    if (!model.log || !this.details.open) return;
    const lane = Number(this.lane.value) || 0;
    const history = await api.history(lane, ...place, this.many);
    if (model.picked === place) this.showHistory(history);
  }

  private show(): void {
    const { cell, picked } = this.model;
    if (!picked) {
      this.box.replaceChildren(make("p", {}, "Click a cell, or press C, move with the arrow keys and press Enter."));
      this.past.replaceChildren();
      return;
    }
    if (!cell) return;
    const place = pairs([
      ["column, row", `${cell.column}, ${cell.row}`],
      ["centre", `x ${metres(cell.x)}, y ${metres(cell.y)}`],
    ]);
    this.box.replaceChildren(place, ...cell.sources.map((s) => this.source(s)));
  }

  private source(source: CellSource): HTMLElement {
    const entries: [string, string][] = [["class", source.touched ? source.class : `${source.class}, never reached`]];
    if (source.interior !== undefined) entries.push(["times in the interior", count(source.interior)]);
    if (source.arc !== undefined) entries.push(["times on the arc", count(source.arc)]);
    for (const [name, value] of source.values) entries.push([name, number(value)]);
    const parts: Node[] = [make("h3", {}, source.name), pairs(entries)];
    if (source.chosen?.length) parts.push(chosen(source.chosen));
    return make("section", { class: "source", "data-source": source.name }, ...parts);
  }

  private showHistory({ total, layers, events, note }: History): void {
    // A counting sensor model counts scans; other readings tell what the log calls theirs.
    const scans = this.model.countsScans(Number(this.lane.value) || 0);
    const parts: Node[] = [];
    if (note) parts.push(make("p", {}, note));
    if (!events.length) parts.push(make("p", {}, "No reading touched this cell yet."));
    else
      parts.push(
        table(
          ["reading", "where", "own", "before → after", "time", scans ? "scan" : "scan id", "sensor", "range"],
          events.map((e) => this.event(e, layers, scans)),
          `readings that touched it: ${count(total)}, latest first`,
        ),
      );
    if (events.length < total) {
      const more = make("button", { type: "button", id: "more-history" }, `more (${count(total - events.length)})`);
      more.addEventListener("click", () => {
        this.many *= 4;
        void this.refresh();
      });
      parts.push(more);
    }
    this.past.replaceChildren(...parts);
  }

  private event(e: HistoryEvent, layers: string[], scans: boolean): (string | Node)[] {
    const range = e.outcome === "no_echo" ? "no echo" : e.range === null ? "–" : metres(e.range);
    return [
      make("span", { title: `line ${e.line}` }, String(e.number)),
      e.region,
      number(e.own),
      change(layers, e.before, e.after),
      seconds(e.t),
      String(scans ? e.scan + 1 : e.scan),
      e.sensor,
      range,
    ];
  }
}

/** What a beam gives to each class: what is not 0. */
function gained(all: [string, number | null][]): string {
  const some = all.filter(([, gain]) => gain !== 0);
  return some.length ? some.map(([name, gain]) => `${name} ${number(gain)}`).join(", ") : "nothing";
}

/** The chosen poses and beams of a counting sensor model, with all their fields. */
function chosen(list: ChosenBeam[]): HTMLElement {
  const keys = [...new Set(list.flatMap((c) => Object.keys(c)))].filter((k) => k !== "pose" && k !== "ray");
  const value = (c: ChosenBeam, key: string): string => {
    if (key === "gained") return gained(c.gained);
    const fields: Record<string, Json> = c;
    const found = key === "scan" ? c.scan + 1 : fields[key];
    if (key === "range") return typeof found === "number" ? metres(found) : "no hit";
    return typeof found === "number" || typeof found === "string" || found === null
      ? number(found)
      : found === undefined
        ? "–"
        : JSON.stringify(found);
  };
  return table(
    keys,
    list.map((c) => keys.map((k) => value(c, k))),
    "chosen poses and beams",
  );
}
