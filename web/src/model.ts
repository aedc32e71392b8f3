// What the page knows, and who wants to hear of it. Parts of the page talk to each other through this alone.

import type {
  Cell,
  CellPoint,
  LaneState,
  LogSource,
  MapSource,
  Session,
  State,
  ViewInfo,
  Working,
  WorkingStep,
} from "./generated/protocol";
import { type SourceId, Tiles } from "./tiles";
import { Viewport } from "./viewport";

export type Source = LogSource | MapSource;

/** The view that the page draws by itself. */
export const WORKING = "working";

/** How two sources are seen together. */
export type Arrangement = "alone" | "over" | "beside";

/** What the user chose to see. */
export interface Look {
  view: string;
  step: WorkingStep;
  marks: boolean;
  outline: boolean;
  axes: boolean;
  follow: boolean;
  /** Of a map: the other source, how it is shown, how strong, and which of its views ("": the same). */
  other: number;
  arrangement: Arrangement;
  opacity: number;
  otherView: string;
}

export type Topic = "session" | "state" | "look" | "pick" | "cell" | "working" | "hover" | "compute" | "view";

/** Of a log how often its lanes were made anew; a map's never are. */
export const generation = (session: Session): number => (session.mode === "log" ? session.generation : 0);

export class Model {
  readonly look: Look = {
    view: "combined",
    step: "own",
    marks: true,
    outline: true,
    axes: true,
    follow: false,
    other: 1,
    arrangement: "alone",
    opacity: 0.5,
    otherView: "",
  };
  state: State | null = null;
  workings: (Working | null)[] = [];
  /** The cell that is inspected, and what is known of it. */
  picked: CellPoint | null = null;
  cell: Cell | null = null;
  /** The cell that keys move, while they do. */
  cursor: CellPoint | null = null;
  hover: CellPoint | null = null;
  readonly viewport: Viewport;
  readonly tiles: Tiles;
  private readonly hearers = new Map<Topic, (() => void)[]>();

  constructor(public session: Session) {
    this.viewport = new Viewport(session.grid, () => this.tell("view"));
    this.tiles = new Tiles(session.levels, generation(session), () => this.tell("view"));
    this.take(session);
  }

  on(topics: Topic[], hear: () => void): void {
    for (const topic of topics) this.hearers.set(topic, [...(this.hearers.get(topic) ?? []), hear]);
  }

  tell(topic: Topic): void {
    this.hearers.get(topic)?.forEach((hear) => hear());
  }

  /** Another session: other lanes, other parameters. */
  replace(session: Session): void {
    this.viewport.regrid(session.grid);
    this.tiles.clear(session.levels, generation(session));
    this.take(session);
    this.tell("session");
    this.tell("state");
  }

  private take(session: Session): void {
    this.session = session;
    this.state = session.mode === "log" ? session.state : null;
    this.workings = session.sources.map(() => null);
    for (const id of this.ids()) this.tiles.changed(id, "all", this.state?.version ?? 0);
    if (!this.views().some((v) => v.name === this.look.view) && this.look.view !== WORKING) {
      this.look.view = (this.views().find((v) => v.group === "main") ?? this.views()[0])?.name ?? "combined";
    }
    this.look.other = Math.min(this.look.other, session.sources.length - 1);
    if (this.picked && !this.inside(this.picked)) this.picked = this.cell = null;
    this.cursor = null;
  }

  /** The log went on, or back. */
  step(state: State): void {
    this.state = state;
    const all: CellPoint[] = [];
    let whole = false;
    state.lanes.forEach((lane, k) => {
      this.tiles.changed(k, lane.changed, state.version);
      if (lane.changed === "all") whole = true;
      else all.push(...lane.changed);
    });
    if (this.session.difference) this.tiles.changed("difference", whole ? "all" : all, state.version);
    this.tell("state");
  }

  choose(change: Partial<Look>): void {
    Object.assign(this.look, change);
    this.tell("look");
  }

  pick(place: CellPoint | null): void {
    this.picked = place;
    this.cell = null;
    this.tell("pick");
  }

  get log(): boolean {
    return this.session.mode === "log";
  }

  private ids(): SourceId[] {
    return [...this.session.sources.keys(), ...(this.session.difference ? (["difference"] as const) : [])];
  }

  source(k: number): Source | undefined {
    return this.session.sources[k];
  }

  /** Whether a source is of a counting sensor model, whose steps are scans. */
  countsScans(k: number): boolean {
    const source = this.source(k);
    return source !== undefined && "method" in source && source.method.startsWith("csm-");
  }

  lane(k: number): LaneState | undefined {
    return this.state?.lanes[k];
  }

  inside([column, row]: CellPoint): boolean {
    const { width, height } = this.session.grid;
    return column >= 0 && row >= 0 && column < width && row < height;
  }

  /** Every view that some source has, each name once. */
  views(): ViewInfo[] {
    const views = new Map<string, ViewInfo>();
    for (const source of this.log ? this.session.sources : this.session.sources.slice(0, 1)) {
      for (const view of source.views) if (!views.has(view.name)) views.set(view.name, view);
    }
    return [...views.values()];
  }

  /** The view that a panel shows: the chosen one, or where its source lacks it the first. */
  shown(id: SourceId): ViewInfo | undefined {
    if (id === "difference") return this.session.difference ?? undefined;
    const views = this.source(id)?.views ?? [];
    const other = !this.log && id > 0 && this.look.otherView;
    const wanted = other || (this.look.view === WORKING ? "combined" : this.look.view);
    return views.find((v) => v.name === wanted) ?? views.find((v) => v.name === "combined") ?? views[0];
  }

  /** The sources that a panel draws. */
  drawnOn(id: SourceId): SourceId[] {
    return !this.log && id === 0 && this.look.arrangement === "over" ? [id, this.look.other] : [id];
  }

  /** What the panels show, left to right. */
  panels(): SourceId[] {
    const { sources, difference } = this.session;
    const beside = this.log ? sources.length > 1 : this.look.arrangement === "beside" && sources.length > 1;
    if (!beside) return [0];
    const other = this.log ? 1 : this.look.other;
    return difference && other === 1 ? [0, other, "difference"] : [0, other];
  }
}
