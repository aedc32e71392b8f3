// The panels: a canvas for each source that is shown, all drawn together once a frame.

import { make } from "./dom";
import { type Brush, type Ink, readInk } from "./draw/brush";
import { drawCells } from "./draw/cells";
import { drawAxes, drawBorder, drawGround, drawOutside } from "./draw/ground";
import { drawPick } from "./draw/pick";
import { drawChosen, drawCurrent } from "./draw/reading";
import { drawTiles } from "./draw/tiles";
import { type Model, WORKING } from "./model";
import type { CellPoint } from "./generated/protocol";
import type { SourceId } from "./tiles";

export interface Panel {
  id: SourceId;
  figure: HTMLElement;
  canvas: HTMLCanvasElement;
  title: HTMLElement;
  /** Says that tiles are still to come. */
  note: HTMLElement;
}

export class Scene {
  panels: Panel[] = [];
  /** Hears of each drawing's end. */
  drawn: () => void = () => {};
  private scheduled = false;
  private ink: Ink = readInk();
  private readonly sizes = new ResizeObserver(() => this.resized());

  constructor(
    private readonly model: Model,
    private readonly box: HTMLElement,
    private readonly made: (panel: Panel) => void,
  ) {
    this.rebuild();
    model.on(["session", "look"], () => this.rebuild());
    model.on(["session", "state", "look", "pick", "cell", "working", "view", "compute"], () => this.request());
    model.on(["state", "look"], () => this.follow());
  }

  /** Whether something is still to be drawn. */
  get drawing(): boolean {
    return this.scheduled;
  }

  /** The panel that has the focus, else the first. */
  get active(): Panel | undefined {
    return this.panels.find((p) => p.figure.contains(document.activeElement)) ?? this.panels[0];
  }

  /** The theme changed. */
  recolour(): void {
    this.ink = readInk();
    this.request();
  }

  request(): void {
    if (this.scheduled) return;
    this.scheduled = true;
    requestAnimationFrame(() => {
      this.scheduled = false;
      this.draw();
    });
  }

  private rebuild(): void {
    const ids = this.model.panels();
    if (ids.join() !== this.panels.map((p) => p.id).join()) {
      this.sizes.disconnect();
      this.panels = ids.map((id) => this.panel(id));
      this.box.replaceChildren(...this.panels.map((p) => p.figure));
      this.box.dataset.count = String(ids.length);
      this.arrange();
      this.sizes.observe(this.box);
      this.panels.forEach((p) => this.sizes.observe(p.canvas));
      this.panels.forEach(this.made);
    }
    this.panels.forEach((p) => this.name(p));
  }

  private panel(id: SourceId): Panel {
    const title = make("figcaption", {});
    const canvas = make("canvas", {
      id: `canvas-${id}`,
      tabindex: 0,
      role: "application",
      "aria-roledescription": "map",
      "aria-describedby": "map-help",
    });
    const note = make("p", { class: "loading", hidden: true }, "loading…");
    const figure = make("figure", { class: "panel", "data-source": id }, title, canvas, note);
    return { id, title, canvas, note, figure };
  }

  private name({ id, title, canvas }: Panel): void {
    const view = this.model.shown(id);
    const working = this.model.look.view === WORKING && id !== "difference";
    const [first, second] = this.model.session.sources;
    const named = id === "difference" ? `${second?.name} less ${first?.name}` : (this.model.source(id)?.name ?? "");
    const shown = working ? `${WORKING} over ${view?.name}` : (view?.name ?? "");
    title.replaceChildren(make("strong", {}, named), ` ${shown}`);
    title.title = view?.about ?? "";
    canvas.setAttribute("aria-label", `Map of ${named}, ${shown}`);
  }

  /** As many columns as show the grid largest. */
  private arrange(): void {
    const { grid } = this.model.session;
    const count = this.panels.length;
    const size = (columns: number) =>
      Math.min(
        this.box.clientWidth / columns / grid.width,
        this.box.clientHeight / Math.ceil(count / columns) / grid.height,
      );
    const best = [1, 2, 3].filter((n) => n <= count).reduce((a, b) => (size(b) > size(a) ? b : a), 1);
    this.box.style.setProperty("--columns", String(best));
  }

  private resized(): void {
    this.arrange();
    const first = this.panels[0]?.canvas;
    if (first) this.model.viewport.resize(first.clientWidth, first.clientHeight);
    this.request();
  }

  /** Zooms about the middle, or about the robot where it is followed. */
  zoom(factor: number): void {
    const { viewport } = this.model;
    const robot = this.followed;
    if (robot) viewport.zoom(factor, ...viewport.toScreen(robot));
    else viewport.zoom(factor);
    this.follow();
  }

  private get followed(): CellPoint | null {
    const robot = this.model.look.follow ? this.model.lane(0)?.current?.robot : null;
    return robot ? this.model.viewport.fromWorld(robot[0], robot[1]) : null;
  }

  private follow(): void {
    if (this.followed) this.model.viewport.show(this.followed);
  }

  /** Draws all of it now. */
  draw(): void {
    this.model.tiles.begin();
    for (const panel of this.panels) this.drawPanel(panel);
    this.model.tiles.end();
    this.drawn();
  }

  private drawPanel({ id, canvas }: Panel): void {
    const { model, ink } = this;
    const ratio = window.devicePixelRatio || 1;
    const width = Math.round(canvas.clientWidth * ratio);
    const height = Math.round(canvas.clientHeight * ratio);
    if (canvas.width !== width) canvas.width = width;
    if (canvas.height !== height) canvas.height = height;
    const context = canvas.getContext("2d", { alpha: false });
    if (!context || !width || !height) return;
    const { viewport, look, session } = model;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    const brush: Brush = { context, viewport, ratio, ink };
    drawOutside(brush);
    const view = model.shown(id);
    const lane = id === "difference" ? 0 : id;
    const working = model.workings[lane];
    const dim = look.view === WORKING && id !== "difference";
    if (view) {
      drawGround(brush, view.legend.untouched);
      const { untouched } = view.legend;
      drawTiles(brush, model.tiles, session.levels, {
        source: id,
        view: view.name,
        untouched,
        opacity: dim ? 0.25 : 1,
      });
    }
    if (!model.log && look.arrangement === "over" && id === 0) this.drawOver(brush);
    if (working && dim) drawCells(brush, lane, working, look.step);
    else if (working && look.marks && id !== "difference") drawCells(brush, lane, working, "marks");
    drawBorder(brush);
    const current = model.lane(lane)?.current;
    if (current && look.outline) drawCurrent(brush, current);
    const chosen = id === "difference" ? undefined : model.cell?.sources[id]?.chosen;
    if (chosen) drawChosen(brush, chosen);
    if (model.picked) drawPick(brush, model.picked, "picked");
    if (model.cursor) drawPick(brush, model.cursor, "cursor");
    if (look.axes) drawAxes(brush);
  }

  /** The other map over the first. */
  private drawOver(brush: Brush): void {
    const { other, opacity } = this.model.look;
    const view = this.model.shown(other);
    if (!view || opacity === 0) return;
    const layer = { source: other, view: view.name, untouched: view.legend.untouched, opacity };
    drawTiles(brush, this.model.tiles, this.model.session.levels, layer);
  }
}
