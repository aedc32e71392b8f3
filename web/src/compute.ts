// The switch between the server's CPU and the browser's GPU, the badge that says which one computed, and what the
// comparison found.

import { ServerError } from "./api";
import { byId, make, pairs } from "./dom";
import { count, number } from "./format";
import { Runner } from "./gpu";
import { type Check, add } from "./gpu-check";
import { open } from "./gpu-device";
import type { Model } from "./model";
import type { State } from "./generated/protocol";

export class Compute {
  private readonly box = byId("gpu", HTMLInputElement);
  private readonly badge = byId("backend", HTMLOutputElement);
  private readonly told = byId("gpu-check", HTMLDivElement);
  private device: GPUDevice | null = null;
  private adapter = "";
  private runners: Runner[] = [];
  private checks: (Check | string)[] = [];
  private running: Promise<void> | null = null;
  /** The look-up of an adapter; what it found says the switch. */
  private readonly looked: Promise<void>;
  private looking = false;
  private opening = false;
  /** Has the log stand still for a moment and follows it there. */
  nudge: () => void = () => {};

  constructor(private readonly model: Model) {
    byId("compute-details", HTMLDetailsElement).hidden = !model.log;
    this.box.addEventListener("change", () => void this.toggle());
    model.on(["session"], () => this.renew());
    this.refresh();
    this.looked = model.log ? this.look() : Promise.resolve();
  }

  get busy(): boolean {
    return this.looking || this.opening || this.running !== null;
  }

  /** The switch is only there where there is something to switch to. */
  private async look(): Promise<void> {
    this.looking = true;
    const gpu = "gpu" in navigator ? await navigator.gpu.requestAdapter().catch(() => null) : null;
    this.box.disabled = !gpu;
    byId("gpu-why", HTMLParagraphElement).textContent = gpu
      ? ""
      : "This browser offers no WebGPU adapter: the server's CPU computes.";
    this.looking = false;
  }

  /** By key: there the switch may be out of sight, so that it is said what came of it. */
  async flip(say: (text: string) => void): Promise<void> {
    await this.looked;
    if (this.box.disabled) return say(byId("gpu-why", HTMLParagraphElement).textContent ?? "");
    this.box.checked = !this.box.checked;
    await this.toggle();
    const why = byId("gpu-why", HTMLParagraphElement).textContent;
    say(why || (this.box.checked ? "this browser's GPU computes" : "the server's CPU computes"));
  }

  /** Ends what is under way, as far as it can be ended. */
  quit(): void {
    this.runners.forEach((r) => r.quit());
  }

  private async toggle(): Promise<void> {
    if (!this.box.checked) {
      this.quit();
      // Unless it was switched on again meanwhile: then it begins anew.
      return this.guard(async () => {
        if (!this.box.checked) this.stop("");
      });
    }
    try {
      if (!this.device) {
        this.opening = true;
        const { device, name } = await open().finally(() => (this.opening = false));
        this.device = device;
        this.adapter = name;
        void device.lost.then((lost) => {
          this.device = null;
          if (this.box.checked)
            this.stop(`The GPU was lost: ${lost.message || lost.reason}. The server's CPU computes.`);
        });
      }
      await this.guard(() => this.begin());
    } catch (e) {
      this.stop(e instanceof Error ? e.message : String(e));
    }
  }

  private async begin(): Promise<void> {
    const { device, model } = this;
    if (!device) return;
    this.runners.forEach((r) => r.close());
    model.tiles.computed.clear();
    this.runners = model.session.sources.map((_, lane) => new Runner(device, lane));
    this.checks = [];
    byId("gpu-why", HTMLParagraphElement).textContent = "";
    await Promise.all(this.runners.map((r) => r.reset()));
    this.nudge();
  }

  /** Another session: its lanes start anew. */
  private renew(): void {
    this.quit();
    this.model.tiles.computed.clear();
    if (this.box.checked) void this.guard(() => this.begin());
    else this.refresh();
  }

  /** Brings every lane's own map to the server's place. */
  async follow(state: State): Promise<void> {
    if (!this.box.checked || !this.runners.length) return;
    const before = this.model.tiles.computed.size;
    await this.guard(() => this.advance(state));
    if (before !== this.model.tiles.computed.size) this.retile();
  }

  /** Until nothing is under way. */
  async settled(): Promise<void> {
    while (this.running) await this.running;
  }

  /** One piece of work after the other; what fails gives the map back to the server. */
  private async guard(work: () => Promise<void>): Promise<void> {
    const running = (this.running ?? Promise.resolve())
      .then(work)
      .catch((e: unknown) => this.stop(e instanceof Error ? e.message : String(e)));
    this.running = running;
    await running;
    if (this.running === running) this.running = null;
    this.refresh();
  }

  private async advance(state: State): Promise<void> {
    for (const runner of this.runners) {
      const lane = state.lanes[runner.lane];
      if (!lane) continue;
      const why = await runner.refusal();
      if (why) {
        this.checks[runner.lane] = why;
        continue;
      }
      const before = runner.position;
      const found = await runner.advance(lane.position).catch((e: unknown) => {
        // Another page moved the log on meanwhile: it is followed there.
        if (e instanceof ServerError && /the log stands at/.test(e.message)) return null;
        throw e;
      });
      if (!found) {
        this.nudge();
        continue;
      }
      const old = this.checks[runner.lane];
      this.checks[runner.lane] = old && typeof old !== "string" && before <= lane.position ? add(old, found) : found;
      this.model.tiles.computed.add(runner.lane);
      if (this.model.session.difference) this.model.tiles.computed.add("difference");
    }
  }

  private stop(why: string): void {
    this.box.checked = false;
    this.runners.forEach((r) => r.close());
    this.runners = [];
    this.checks = [];
    this.model.tiles.computed.clear();
    byId("gpu-why", HTMLParagraphElement).textContent = why;
    this.retile();
  }

  private retile(): void {
    this.refresh();
    this.model.tell("compute");
  }

  private refresh(): void {
    const { sources } = this.model.session;
    const on = this.box.checked && this.model.tiles.computed.size > 0;
    const several = sources.length > 1;
    this.badge.value = on ? `WebGPU: ${this.adapter}` : "server CPU";
    this.badge.dataset.backend = on ? "webgpu" : "cpu";
    this.told.replaceChildren(
      ...(this.box.checked ? this.checks : []).map((check, lane) => {
        const name = several ? [make("h3", {}, sources[lane]?.name ?? "")] : [];
        if (typeof check === "string") return make("section", {}, ...name, make("p", {}, `Server CPU: ${check}`));
        const exact = check.membership === 0;
        const list = pairs([
          ["tiles compared", count(check.tiles)],
          ["cells compared", count(check.cells)],
          ["membership differences", `${count(check.membership)}${exact ? "" : " – must be 0"}`],
          ["value differences", count(check.values)],
          ["largest", number(check.largest)],
        ]);
        list.classList.add(exact ? "good" : "bad");
        list.dataset.membership = String(check.membership);
        return make("section", { "data-check": lane }, ...name, list);
      }),
    );
  }
}
