// Plays the log at a chosen speed. Where the server is slower than that, it plays as fast as the server.

import type { Model } from "./model";
import type { Stepper } from "./stepper";

export class Player {
  by: "reading" | "scan" = "scan";
  rate = 5;
  private timer = 0;
  private last = 0;
  private due = 0;

  constructor(
    private readonly model: Model,
    private readonly stepper: Stepper,
    /** Whether what was shown last is on screen: a step nobody sees is no step. */
    private readonly shown: () => boolean,
    private readonly changed: () => void,
  ) {}

  get playing(): boolean {
    return this.timer !== 0;
  }

  toggle(): void {
    if (this.playing) this.pause();
    else this.play();
  }

  play(): void {
    this.last = performance.now();
    this.due = 1;
    this.timer = window.setTimeout(() => this.tick());
    this.changed();
  }

  pause(): void {
    clearTimeout(this.timer);
    this.timer = 0;
    this.stepper.stop();
    this.changed();
  }

  private tick(): void {
    // Before the next step: a quick one has one due with every tick.
    const { state } = this.model;
    if (state && state.position >= state.total && !this.stepper.busy) return this.pause();
    const now = performance.now();
    // At most a second's worth: who comes back from another tab wants no leap.
    this.due = Math.min(this.due + ((now - this.last) / 1000) * this.rate, Math.max(1, this.rate));
    this.last = now;
    if (this.due >= 1 && !this.stepper.busy && this.shown()) {
      const count = Math.floor(this.due);
      this.due -= count;
      void this.stepper.go({ by: this.by, count });
    }
    // Who asked for little motion gets two pictures a second, each with more of the log.
    const calm = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.timer = window.setTimeout(() => this.tick(), calm ? 500 : 16);
  }
}
