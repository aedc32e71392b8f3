// The lanes' methods and parameters. A change is sent as it is made; where the server refuses it, its words stand
// beside the form and the map stays as it was.

import { api } from "./api";
import { byId, later, make } from "./dom";
import type { Model } from "./model";
import type { LaneSpec, LogSession, ParameterInfo, Session } from "./generated/protocol";
import { brief, choices, fromSlider, range, toSlider, words } from "./values";

export class Parameters {
  private readonly form = byId("lanes", HTMLFormElement);
  private readonly error = byId("lanes-error", HTMLParagraphElement);
  private readonly add = byId("add-lane", HTMLButtonElement);
  private readonly remove = byId("remove-lane", HTMLButtonElement);
  /** What the user wants; what holds is in the session. */
  private asked: LaneSpec[] = [];
  private built = "";
  private running = false;
  private again = false;
  private readonly soon = later(250, () => void this.send());
  /** Hears that nothing waits any more. */
  done: () => void = () => {};
  /** The log must stand still while lanes are changed, and what a new session needs follows. */
  around: (change: () => Promise<Session>) => Promise<Session> = (change) => change();

  constructor(private readonly model: Model) {
    this.form.addEventListener("submit", (e) => {
      e.preventDefault();
      void this.send();
    });
    this.add.addEventListener("click", () => this.second());
    this.remove.addEventListener("click", () => this.ask(this.asked.slice(0, 1)));
    model.on(["session"], () => this.refresh());
    this.refresh();
  }

  /** Questions that wait or are not yet answered. */
  get busy(): boolean {
    return this.running;
  }

  private get session(): LogSession {
    const { session } = this.model;
    if (session.mode !== "log") throw new Error("only a log has parameters");
    return session;
  }

  private second(): void {
    const first = this.asked[0];
    const other = this.session.methods.find((m) => m.name !== first?.method);
    if (first) this.ask([first, { method: other?.name ?? first.method, set: {} }]);
  }

  private ask(lanes: LaneSpec[]): void {
    this.asked = lanes;
    void this.send();
  }

  private async send(): Promise<void> {
    if (this.running) {
      this.again = true;
      return;
    }
    this.running = true;
    document.body.classList.add("changing");
    try {
      do {
        this.again = false;
        const lanes = structuredClone(this.asked);
        const session = await this.around(() => api.lanes(lanes));
        this.error.textContent = "";
        if (!this.again) this.model.replace(session);
      } while (this.again);
    } catch (e) {
      this.error.textContent = `${e instanceof Error ? e.message : String(e)} – nothing was changed.`;
    } finally {
      this.running = false;
      document.body.classList.remove("changing");
      if (this.again) void this.send();
      else {
        if (this.error.textContent) this.marks();
        this.done();
      }
    }
  }

  /** What was refused stays in its field, marked; a refused method goes back to the one that holds. */
  private marks(): void {
    const { sources } = this.session;
    const same = sources.length === this.asked.length && sources.every((s, k) => s.method === this.asked[k]?.method);
    if (!same) this.asked = sources.map((s) => ({ method: s.method, set: { ...s.set } }));
    if (!same) this.build();
    for (const field of this.form.querySelectorAll<HTMLElement>("[data-key]")) {
      const held = sources[Number(field.dataset.lane)]?.set[field.dataset.key ?? ""];
      const wanted = this.asked[Number(field.dataset.lane)]?.set[field.dataset.key ?? ""];
      field.setAttribute("aria-invalid", String(held !== wanted));
    }
  }

  private refresh(): void {
    const { sources } = this.session;
    this.asked = sources.map((s) => ({ method: s.method, set: { ...s.set } }));
    this.add.hidden = sources.length > 1;
    this.remove.hidden = sources.length < 2;
    if (this.built !== sources.map((s) => s.method).join()) this.build();
    else this.update();
  }

  private build(): void {
    const { sources, methods, sensor_keys } = this.session;
    this.built = sources.map((s) => s.method).join();
    this.form.replaceChildren(
      ...sources.map((source, lane) => {
        const method = methods.find((m) => m.name === source.method);
        const select = make(
          "select",
          { id: `method-${lane}`, "data-lane-method": lane },
          ...methods.map((m) => make("option", { value: m.name, title: `${m.about} (${m.source})` }, m.name)),
        );
        select.value = source.method;
        select.addEventListener("change", () => {
          this.asked[lane] = { method: select.value, set: this.kept(lane, sensor_keys) };
          void this.send();
        });
        const reset = make("button", { type: "button", title: "sets every parameter back" }, "Defaults");
        reset.addEventListener("click", () => {
          this.asked[lane] = { method: select.value, set: {} };
          void this.send();
        });
        const group = (title: string, keys: ParameterInfo[]) =>
          keys.length ? [make("h4", {}, title), ...keys.map((key) => this.row(lane, key))] : [];
        return make(
          "fieldset",
          { "data-lane": lane },
          make("legend", {}, sources.length > 1 ? (lane === 0 ? "Left" : "Right") : "Method"),
          make("div", { class: "row" }, make("label", { for: select.id }, "method"), select, reset),
          make("p", { class: "about" }, `${method?.about ?? ""} (${method?.source ?? ""})`),
          ...group("sensor", sensor_keys),
          ...group(source.method, method?.keys ?? []),
        );
      }),
    );
    this.update();
  }

  /** The sensor's keys stay when the method changes. */
  private kept(lane: number, keys: ParameterInfo[]): Record<string, string> {
    const set = this.asked[lane]?.set ?? {};
    return Object.fromEntries(Object.entries(set).filter(([name]) => keys.some((k) => k.name === name)));
  }

  private set(lane: number, name: string, value: string): void {
    const ask = this.asked[lane];
    if (!ask) return;
    if (value.trim() === "") delete ask.set[name];
    else ask.set[name] = value.trim();
    this.soon();
  }

  private row(lane: number, key: ParameterInfo): HTMLElement {
    const id = `set-${lane}-${key.name}`;
    const about = make("small", { id: `${id}-about` }, `${key.about}; ${key.values}`);
    const common = { id, "data-lane": lane, "data-key": key.name, "aria-describedby": about.id };
    const label = make("label", { for: id }, key.name);
    const options = choices(key);
    if (options) {
      const select = make(
        "select",
        common,
        make("option", { value: "" }, `default: ${key.default}`),
        ...options.map((o) => make("option", { value: o }, o)),
      );
      select.addEventListener("change", () => this.set(lane, key.name, select.value));
      return make("div", { class: "row" }, label, select, about);
    }
    const field = make("input", { ...common, type: "text", spellcheck: "false", autocomplete: "off" });
    const row = make("div", { class: "row" }, label, field, about);
    const others = words(key);
    if (others.length) {
      field.setAttribute("list", `${id}-words`);
      row.append(make("datalist", { id: `${id}-words` }, ...others.map((w) => make("option", { value: w }))));
    }
    field.addEventListener("change", () => this.set(lane, key.name, field.value));
    const reach = range(key, this.held(lane, key));
    if (reach) {
      const slider = make("input", {
        type: "range",
        min: 0,
        max: 1000,
        "aria-label": `${key.name}, slider`,
        "data-slider": key.name,
      });
      slider.addEventListener("input", () => {
        field.value = fromSlider(reach, Number(slider.value));
        slider.setAttribute("aria-valuetext", field.value);
        this.set(lane, key.name, field.value);
      });
      field.addEventListener("input", () => (slider.value = String(toSlider(reach, field.value))));
      field.after(slider);
    }
    return row;
  }

  /** What a key is now: set, or as it applies, or the default. */
  private held(lane: number, key: ParameterInfo): string {
    const source = this.session.sources[lane];
    return source?.set[key.name] ?? source?.parameters[key.name] ?? key.default;
  }

  private update(): void {
    const { sources, methods, sensor_keys } = this.session;
    sources.forEach((source, lane) => {
      const keys = [...sensor_keys, ...(methods.find((m) => m.name === source.method)?.keys ?? [])];
      for (const key of keys) {
        const field = document.getElementById(`set-${lane}-${key.name}`);
        const set = source.set[key.name] ?? "";
        field?.removeAttribute("aria-invalid");
        if (field instanceof HTMLSelectElement) field.value = set;
        if (!(field instanceof HTMLInputElement)) continue;
        field.placeholder = brief(key, source.parameters[key.name] ?? key.default);
        // What is being typed is the user's.
        if (document.activeElement !== field) field.value = set;
        const slider = field.nextElementSibling;
        const reach = range(key, this.held(lane, key));
        const still = slider instanceof HTMLInputElement && document.activeElement !== slider;
        if (still && reach) slider.value = String(toSlider(reach, this.held(lane, key)));
      }
    });
  }
}
