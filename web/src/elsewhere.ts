// Another tab, or another page, may change the log's place or its lanes: every answer tells what it is of, and where
// that is newer than what the page shows, the page follows.

import { api, heard } from "./api";
import { generation, type Model } from "./model";
import type { Stamp } from "./generated/protocol";
import type { Stepper } from "./stepper";

export class Elsewhere {
  private newest: Stamp = { version: 0, generation: 0 };
  private running = false;
  /** Whether the page itself is changing what it would be told of. */
  changing: () => boolean = () => false;
  /** Whatever goes on must stand still before the session is taken anew. */
  still: () => Promise<void> = () => Promise.resolve();

  constructor(
    private readonly model: Model,
    private readonly stepper: Stepper,
    private readonly failed: (why: string) => void,
    private readonly told: (what: string) => void,
  ) {
    heard.hear = (of) => this.hear(of);
    stepper.remade = (of) => this.hear(of);
    stepper.arrived = () => this.check();
    const look = () => {
      if (document.visibilityState === "visible") this.ask();
    };
    document.addEventListener("visibilitychange", look);
    window.addEventListener("focus", look);
  }

  /** Whether the session is being taken anew. */
  get busy(): boolean {
    return this.running;
  }

  private hear({ version, generation }: Stamp): void {
    this.newest = {
      version: Math.max(version, this.newest.version),
      generation: Math.max(generation, this.newest.generation),
    };
    this.check();
  }

  /** Asks where the log stands: without a step, and without a word where nothing changed. */
  private ask(): void {
    if (!this.stepper.busy && !this.running && !this.changing()) void this.stepper.go({ by: "reading", count: 0 });
  }

  /** Follows, unless what is newer may be the page's own doing: then it is asked again when that has ended. */
  check(): void {
    if (this.running || this.changing()) return;
    if (this.newest.generation > generation(this.model.session)) void this.renew();
    else if (this.newest.version > (this.model.state?.version ?? 0)) this.ask();
  }

  private async renew(): Promise<void> {
    this.running = true;
    try {
      await this.still();
      this.model.replace(await api.session());
      this.told("the method or its parameters were changed elsewhere");
    } catch (e) {
      return this.failed(e instanceof Error ? e.message : String(e));
    } finally {
      this.running = false;
    }
    // Meanwhile it may have gone on.
    this.check();
  }
}
