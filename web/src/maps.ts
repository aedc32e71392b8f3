// Saved maps: another map or the truth beside or over the first, the scores, the report.

import { byId, make, pairs } from "./dom";
import { number } from "./format";
import type { Arrangement, Model } from "./model";
import type { Json, LogSession, MapSession } from "./generated/protocol";

/** A tree of JSON: plain values as pairs, what holds others as a part that opens. */
function tree(value: { [key: string]: Json }): Node[] {
  const plain: [string, string][] = [];
  const deep: Node[] = [];
  for (const [key, inner] of Object.entries(value)) {
    const name = key.replaceAll("_", " ");
    if (inner === null || typeof inner !== "object") {
      plain.push([name, typeof inner === "number" ? number(inner) : String(inner ?? "–")]);
    } else if (Array.isArray(inner)) {
      plain.push([name, inner.map((v) => (typeof v === "object" ? JSON.stringify(v) : String(v))).join(", ")]);
    } else {
      deep.push(make("details", {}, make("summary", {}, name), ...tree(inner)));
    }
  }
  return [...(plain.length ? [pairs(plain)] : []), ...deep];
}

/** What came of a log's lines: used, rejected and why, bad lines with their beginnings. */
export function showReport({ report }: LogSession): void {
  const { readings, bad_lines: bad } = report;
  byId("report-details", HTMLDetailsElement).hidden = !isTree(readings);
  if (!isTree(readings)) return;
  const parts = tree(readings);
  parts.filter((p) => p instanceof HTMLDetailsElement).forEach((p) => (p.open = true));
  parts.push(pairs([["bad lines", number(bad.count)]]));
  if (bad.first.length) parts.push(make("ul", {}, ...bad.first.map((line) => make("li", {}, line))));
  byId("report", HTMLDivElement).replaceChildren(...parts);
}

const isTree = (value: Json | undefined): value is { [key: string]: Json } =>
  typeof value === "object" && value !== null && !Array.isArray(value);

export function showMaps(model: Model, { sources, report, score }: MapSession): void {
  const { look } = model;
  const several = sources.length > 1;
  byId("compare-details", HTMLDetailsElement).hidden = !several;
  byId("score-details", HTMLDetailsElement).hidden = !isTree(score);
  byId("report-details", HTMLDetailsElement).hidden = !isTree(report);
  if (isTree(score)) byId("score", HTMLDivElement).replaceChildren(...tree(score));
  if (isTree(report)) byId("report", HTMLDivElement).replaceChildren(...tree(report));
  if (!several) return;

  const other = byId("other", HTMLSelectElement);
  const view = byId("other-view", HTMLSelectElement);
  const opacity = byId("opacity", HTMLInputElement);
  const arrangement = byId("arrangement", HTMLSelectElement);
  other.replaceChildren(
    ...sources
      .slice(1)
      .map((s, k) => make("option", { value: k + 1 }, `${s.name}${s.kind === "truth" ? " (truth)" : ""}`)),
  );
  const views = () => {
    const names = model.source(look.other)?.views.map((v) => v.name) ?? [];
    view.replaceChildren(
      make("option", { value: "" }, "the same"),
      ...names.map((n) => make("option", { value: n }, n)),
    );
    view.value = names.includes(look.otherView) ? look.otherView : "";
  };
  other.addEventListener("change", () => {
    model.choose({ other: Number(other.value), otherView: "" });
    views();
  });
  view.addEventListener("change", () => model.choose({ otherView: view.value }));
  arrangement.addEventListener("change", () => model.choose({ arrangement: arrangement.value as Arrangement }));
  opacity.addEventListener("input", () => model.choose({ opacity: Number(opacity.value) / 100 }));
  const refresh = () => {
    byId("opacity-field", HTMLLabelElement).hidden = look.arrangement !== "over";
    opacity.setAttribute("aria-valuetext", `${opacity.value} %`);
  };
  model.on(["look"], refresh);
  views();
  refresh();
}
