// Goes through the log: one question at a time, in the order they were asked. A long way is gone in pieces, so that the
// map is seen to grow and the user can stop it.

import { api, type GoTarget } from "./api";
import { generation, type Model } from "./model";
import type { Stamp, State } from "./generated/protocol";

/** Milliseconds that the server may take for a piece. */
const BUDGET = 200;

export class Stepper {
  private queue: GoTarget[] = [];
  private running = false;
  private stopped = false;
  private asks = false;
  /** What must be done with a new state before it is shown. */
  before: (state: State) => Promise<void> = () => Promise.resolve();
  /** The lanes are no longer those that the page knows. */
  remade: (of: Stamp) => void = () => {};
  /** It stands still where the server said. */
  arrived: () => void = () => {};

  constructor(
    private readonly model: Model,
    private readonly failed: (why: string) => void,
    private readonly changed: () => void,
  ) {}

  get busy(): boolean {
    return this.running;
  }

  /** Whether it is on its way; who only asks where the log stands is not. */
  get going(): boolean {
    return this.running && !this.asks;
  }

  /** By so many readings or scans, or to a reading; going to one forgets the steps that wait. */
  async go(ask: GoTarget): Promise<void> {
    const last = this.queue.at(-1);
    if ("to" in ask) this.queue = [ask];
    else if (last && "by" in last && last.by === ask.by) last.count += ask.count;
    else this.queue.push({ ...ask });
    if (!this.running) await this.run();
  }

  /** Stops where the piece under way ends. */
  stop(): void {
    this.queue = [];
    this.stopped = true;
  }

  /** Stops, and waits until it stands still. */
  async halt(): Promise<void> {
    this.stop();
    while (this.running) await new Promise((next) => setTimeout(next, 10));
  }

  private async run(): Promise<void> {
    this.running = true;
    let remade: State | null = null;
    let good = true;
    try {
      for (let ask = this.queue.shift(); ask; ask = this.queue.shift()) {
        this.stopped = false;
        this.asks = "by" in ask && ask.count === 0;
        this.changed();
        const { version } = this.model.state ?? {};
        const state = await api.go(ask, version, BUDGET);
        if (state.generation !== generation(this.model.session)) {
          remade = state;
          this.queue = [];
          break;
        }
        await this.before(state);
        // Who only asks need not hear that nothing changed.
        if (state.version !== version || !this.asks) this.model.step(state);
        const target = "to" in ask ? ask.to : state.target;
        const on = !state.done && !this.stopped && !this.queue.some((q) => "to" in q);
        if (on && target !== undefined) this.queue.unshift({ to: target });
      }
    } catch (e) {
      good = false;
      this.queue = [];
      this.failed(e instanceof Error ? e.message : String(e));
    } finally {
      this.running = false;
      this.changed();
    }
    if (remade) this.remade(remade);
    else if (good) this.arrived();
  }
}
