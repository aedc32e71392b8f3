// What the colours mean: a scale or classes for each panel, and the signs that are drawn over them.

import { byId, make } from "./dom";
import { strongestOf } from "./draw/cells";
import { count, number } from "./format";
import { type Model, WORKING } from "./model";
import type { Current, ViewInfo, Working, WorkingStep } from "./generated/protocol";
import { nothing } from "./reading-panel";

function swatch(colour: string, text: string, kind = ""): HTMLElement {
  const patch = make("span", { class: `swatch ${kind}`, "aria-hidden": "true" });
  patch.style.setProperty("--patch", colour);
  return make("span", { class: "entry" }, patch, text);
}

function scale(stops: [string, string][]): HTMLElement {
  const bar = make("div", { class: "scale", role: "img" });
  bar.setAttribute("aria-label", `colours from ${stops[0]?.[0]} to ${stops.at(-1)?.[0]}`);
  bar.style.background = `linear-gradient(to right, ${stops.map(([, colour]) => colour).join(", ")})`;
  const ticks = stops.length > 5 ? stops.filter((_, k) => k % Math.ceil((stops.length - 1) / 4) === 0) : stops;
  return make("div", {}, bar, make("div", { class: "ticks" }, ...ticks.map(([text]) => make("span", {}, text))));
}

function describe(title: string, view: ViewInfo): HTMLElement {
  const { legend } = view;
  const colours =
    legend.kind === "scale"
      ? [scale(legend.stops)]
      : [make("div", { class: "entries" }, ...legend.entries.map(([name, colour]) => swatch(colour, name)))];
  const untouched = make("div", { class: "entries" }, swatch(legend.untouched, "not reached by any reading"));
  return make(
    "section",
    { "data-legend": view.name },
    make("h3", {}, title),
    make("p", {}, view.about),
    ...colours,
    untouched,
  );
}

/** The shades of the working view: each is relative to this reading, so that its strong end is told. */
function shades(title: string, working: Working | null, step: WorkingStep, current: Current | null): HTMLElement {
  const own = working?.own_is ? `; own = ${working.own_is}` : "";
  const about = `What the current reading says of each cell, relative to where it says most${own}.`;
  const why = current ? nothing(current, working) : "";
  const said = [make("p", {}, about), ...(why ? [make("p", { class: "nothing" }, why)] : [])];
  const strongest = working ? { value: working.strongest, is: working.strength_is } : null;
  const arc = (working && strongestOf(working, step)) ?? strongest;
  const bar = (region: string, colour: string, end: typeof strongest) =>
    scale([
      ["0", `rgb(${colour} / 8%)`],
      [`${region}, strongest${end ? `: ${number(end.value)} (${end.is})` : ""}`, `rgb(${colour})`],
    ]);
  const bars = [bar("interior", "37 99 235", strongest), bar("arc", "220 38 38", arc)];
  return make("section", { "data-legend": WORKING }, make("h3", {}, title), ...said, ...bars);
}

export function showLegend(model: Model): void {
  const box = byId("legend", HTMLDivElement);
  const refresh = () => {
    const parts = model.panels().flatMap((id) => {
      const view = model.shown(id);
      if (!view) return [];
      const name = id === "difference" ? "difference" : (model.source(id)?.name ?? "");
      return [describe(`${name}: ${view.name}`, view)];
    });
    if (!model.log && model.look.arrangement === "over") {
      const view = model.shown(model.look.other);
      if (view) parts.push(describe(`over it, ${model.source(model.look.other)?.name ?? ""}: ${view.name}`, view));
    }
    if (model.log && model.look.view === WORKING) {
      const several = model.session.sources.length > 1;
      model.session.sources.forEach((source, k) => {
        const current = model.lane(k)?.current;
        const title = several ? `${source.name}: working` : "working";
        parts.push(shades(title, model.workings[k] ?? null, model.look.step, current ?? null));
      });
    }
    if (model.log) {
      parts.push(
        make(
          "section",
          {},
          make("h3", {}, "signs"),
          make(
            "div",
            { class: "entries" },
            swatch("var(--robot)", "robot", "round"),
            swatch("var(--cone)", "the cone's outline, its axis dashed", "line"),
            swatch("var(--mark-interior)", "interior cells"),
            swatch("var(--mark-arc)", "arc cells"),
            swatch("var(--picked)", "inspected cell", "frame"),
          ),
        ),
      );
    }
    const { resolution, width, height } = model.session.grid;
    parts.push(make("p", {}, `${count(width)} × ${count(height)} cells of ${number(resolution)} m.`));
    box.replaceChildren(...parts);
  };
  model.on(["session", "look"], refresh);
  model.on(["working"], () => {
    if (model.look.view === WORKING) refresh();
  });
  refresh();
}
