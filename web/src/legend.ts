// What the colours mean: a scale or classes for each panel, and the signs that are drawn over them.

import { byId, make } from "./dom";
import { count, number } from "./format";
import { type Model, WORKING } from "./model";
import type { View } from "./protocol";

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

function describe(title: string, view: View): HTMLElement {
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
      const working = model.workings[0];
      parts.push(
        make(
          "section",
          { "data-legend": WORKING },
          make("h3", {}, "working"),
          make(
            "p",
            {},
            `What the current reading says of each cell, stronger where it says more${working?.own_is ? `; own = ${working.own_is}` : ""}.`,
          ),
          scale([
            ["0", "rgb(37 99 235 / 8%)"],
            ["interior, strongest", "rgb(37 99 235)"],
          ]),
          scale([
            ["0", "rgb(220 38 38 / 8%)"],
            ["arc, strongest", "rgb(220 38 38)"],
          ]),
        ),
      );
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
  refresh();
}
