// The choice of what is shown: the main views, the method's further layers, the step of the working view, marks and
// outlines.

import { byId, make } from "./dom";
import { type Model, WORKING } from "./model";
import type { WorkingStep } from "./generated/protocol";

const STEPS: [WorkingStep, string][] = [
  ["own", "own"],
  ["cancelled", "cancelled"],
  ["normalised", "normalised"],
];

export class Views {
  private readonly main = byId("main-views", HTMLDivElement);
  private readonly layers = byId("layers", HTMLSelectElement);
  private readonly step = byId("step", HTMLSelectElement);

  constructor(private readonly model: Model) {
    this.layers.addEventListener("change", () => {
      if (this.layers.value) model.choose({ view: this.layers.value });
    });
    this.step.addEventListener("change", () => model.choose({ step: this.step.value as WorkingStep }));
    for (const what of ["marks", "outline", "axes", "follow"] as const) {
      const box = byId(what, HTMLInputElement);
      box.checked = model.look[what];
      box.addEventListener("change", () => model.choose({ [what]: box.checked }));
    }
    model.on(["session"], () => this.rebuild());
    model.on(["look", "working"], () => this.refresh());
    this.rebuild();
  }

  /** The main views' names, in the order of their keys. */
  get names(): string[] {
    const names = this.model
      .views()
      .filter((v) => v.group === "main")
      .map((v) => v.name);
    return this.model.log ? [...names, WORKING] : names;
  }

  private rebuild(): void {
    this.main.replaceChildren(
      ...this.names.map((name, k) => {
        const about =
          this.model.views().find((v) => v.name === name)?.about ?? "what the current reading says of each cell";
        const button = make("button", { type: "button", "data-view": name, title: `${about} (${k + 1})` }, name);
        button.addEventListener("click", () => this.model.choose({ view: name }));
        return button;
      }),
    );
    const layers = this.model.views().filter((v) => v.group === "layer");
    this.layers.replaceChildren(
      make("option", { value: "" }, "more layers…"),
      ...layers.map((v) => make("option", { value: v.name, title: v.about }, v.name)),
    );
    this.layers.disabled = layers.length === 0;
    this.refresh();
  }

  private refresh(): void {
    const { look, workings } = this.model;
    for (const button of this.main.querySelectorAll("button")) {
      button.setAttribute("aria-pressed", String(button.dataset.view === look.view));
    }
    this.layers.value = this.names.includes(look.view) ? "" : look.view;
    const steps = new Set(workings.flatMap((w) => w?.steps ?? []));
    byId("step-field", HTMLLabelElement).hidden = look.view !== WORKING || steps.size < 2;
    this.step.replaceChildren(
      ...STEPS.filter(([s]) => s === look.step || steps.has(s)).map(([s, text]) => make("option", { value: s }, text)),
    );
    this.step.value = look.step;
    byId("marks", HTMLInputElement).disabled = look.view === WORKING;
  }
}
