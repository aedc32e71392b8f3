// Tells that tiles are still to come, where they are long in coming: the layers of a huge map take seconds at first.

import type { Model } from "./model";
import type { Scene } from "./scene";

/** Milliseconds until a panel says so, and until it is read aloud. */
const SHOWN = 300;
const SAID = 1200;

export class Loading {
  private since = 0;
  private timer = 0;
  private said = false;

  constructor(
    private readonly model: Model,
    private readonly scene: Scene,
    private readonly say: (text: string) => void,
  ) {
    scene.drawn = () => this.refresh();
  }

  private refresh(): void {
    clearTimeout(this.timer);
    const { tiles } = this.model;
    const now = performance.now();
    if (!tiles.missing) {
      if (this.said) this.say("loaded");
      this.since = 0;
      this.said = false;
    } else if (!this.since) this.since = now;
    const waited = this.since ? now - this.since : 0;
    for (const { id, note } of this.scene.panels) {
      note.hidden = waited < SHOWN || !this.model.drawnOn(id).some((source) => tiles.lacks(source));
    }
    if (!this.since) return;
    if (waited >= SAID && !this.said) {
      this.said = true;
      this.say("loading…");
    }
    const next = [SHOWN, SAID].find((wait) => wait > waited);
    if (next) this.timer = window.setTimeout(() => this.refresh(), Math.ceil(next - waited));
  }
}
