// What the current reading says, cell by cell: fetched for every lane after a step, the newest only.

import { api } from "./api";
import { type Model, WORKING } from "./model";

export class Evidence {
  private running = false;
  private again = false;
  /** Whether some other part of the page shows it. */
  shown: () => boolean = () => true;

  constructor(private readonly model: Model) {
    model.on(["state", "session"], () => void this.refresh());
    model.on(["look"], () => {
      if (this.stale) void this.refresh();
    });
    void this.refresh();
  }

  /** Whether it is still being fetched. */
  get busy(): boolean {
    return this.running;
  }

  private get wanted(): boolean {
    return this.model.log && (this.model.look.marks || this.model.look.view === WORKING || this.shown());
  }

  private get stale(): boolean {
    return this.model.session.sources.some((_, k) => this.model.workings[k]?.position !== this.model.lane(k)?.position);
  }

  async refresh(): Promise<void> {
    if (this.running) {
      this.again = true;
      return;
    }
    this.running = true;
    try {
      do {
        this.again = false;
        await this.fetch();
      } while (this.again);
    } finally {
      this.running = false;
    }
  }

  private async fetch(): Promise<void> {
    const { model } = this;
    const session = model.session;
    const none = session.sources.map(() => null);
    if (!this.wanted) {
      model.workings = none;
    } else {
      const lane = async (_: unknown, k: number) => (model.lane(k)?.current ? api.working(k).catch(() => null) : null);
      const found = await Promise.all(session.sources.map(lane));
      if (model.session !== session) {
        this.again = true;
        return;
      }
      // While it plays the log may be further on already: those cells are the last reading's, not this one's.
      model.workings = found.map((w, k) => (w && w.position === model.lane(k)?.position ? w : null));
    }
    model.tell("working");
  }
}
