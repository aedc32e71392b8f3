// Puts the page together.

import { api, unanswered } from "./api";
import { Compute } from "./compute";
import { byId, make } from "./dom";
import { Elsewhere } from "./elsewhere";
import { Evidence } from "./evidence";
import { Hover } from "./hover";
import { Inspect } from "./inspect";
import { Keys, type Shortcut } from "./keys";
import { showLegend } from "./legend";
import { Loading } from "./loading";
import { showMaps, showReport } from "./maps";
import { Model } from "./model";
import { Parameters } from "./parameters";
import { Player } from "./player";
import { listen } from "./pointer";
import type { Session } from "./generated/protocol";
import { ReadingPanel } from "./reading-panel";
import { save } from "./save";
import { Scene } from "./scene";
import { Stepper } from "./stepper";
import { startTheme } from "./theme";
import { MOVES, Transport, position } from "./transport";
import { Views } from "./views";

/** What tests of the whole page may ask. */
interface Hook {
  ready(): Promise<void>;
  state(): unknown;
}

declare global {
  interface Window {
    echogrid?: Hook;
  }
}

let themed = (): void => {};

const live = byId("live", HTMLDivElement);
const say = (text: string): void => {
  live.textContent = text;
};

const failed = (why: string): void => {
  byId("error-text", HTMLSpanElement).textContent = why;
  byId("error", HTMLDivElement).hidden = !why;
};

/** What the user did not do. */
const notice = (what: string): void => {
  byId("notice-text", HTMLSpanElement).textContent = what;
  byId("notice", HTMLDivElement).hidden = !what;
  // Moving the log or the page says something too: this comes last.
  if (what) setTimeout(() => say(what));
};

function head(session: Session): void {
  document.title = `${session.name} – echogrid`;
  byId("name", HTMLSpanElement).textContent = session.name;
  byId("version", HTMLSpanElement).textContent = session.version;
  document.body.dataset.mode = session.mode;
  byId("error-close", HTMLButtonElement).addEventListener("click", () => failed(""));
  byId("notice-close", HTMLButtonElement).addEventListener("click", () => notice(""));
}

function start(session: Session): void {
  head(session);
  const model = new Model(session);
  const scene = new Scene(model, byId("panels", HTMLDivElement), (panel) => listen(model, panel.canvas));
  new Loading(model, scene, say);
  themed = () => scene.recolour();
  const compute = new Compute(model);
  const views = new Views(model);
  const hover = new Hover(model);
  showLegend(model);
  new Inspect(model, failed);
  const keep = () => save(model, scene);
  byId("save", HTMLButtonElement).addEventListener("click", keep);
  for (const [id, run] of [
    ["zoom-in", () => scene.zoom(1.5)],
    ["zoom-out", () => scene.zoom(1 / 1.5)],
    ["fit", () => model.viewport.fit()],
  ] as const)
    byId(id, HTMLButtonElement).addEventListener("click", run);

  const log = session.mode === "log";
  const idle: (() => boolean)[] = [() => !scene.drawing, () => unanswered() === 0, () => model.tiles.missing === 0];
  let steps: Shortcut[] = [];
  if (log) steps = startLog(model, compute, idle);
  if (session.mode === "map") showMaps(model, session);

  new Keys(
    model,
    [
      ...steps,
      ...[1, 2, 3, 4].map((n): Shortcut => ({
        keys: [String(n)],
        shown: String(n),
        does: `view ${views.names[n - 1]}`,
        when: views.names.length >= n,
        run: () => {
          const view = views.names[n - 1];
          if (view) model.choose({ view });
        },
      })),
      { keys: ["+", "="], shown: "+", does: "nearer", run: () => scene.zoom(1.5) },
      { keys: ["-", "_"], shown: "−", does: "farther", run: () => scene.zoom(1 / 1.5) },
      { keys: ["0"], shown: "0", does: "all of the grid", run: () => model.viewport.fit() },
      { keys: ["s"], shown: "S", does: "save the panel as a PNG", run: keep },
      { keys: ["?"], shown: "?", does: "this list", run: () => byId("help", HTMLButtonElement).click() },
    ],
    say,
    (place) => hover.where(place),
  );
  freeFocus();

  window.echogrid = {
    ready: () => settled(idle),
    state: () => ({
      mode: session.mode,
      state: model.state,
      look: { ...model.look },
      panels: model.panels(),
      picked: model.picked,
      cell: model.cell,
      viewport: { centre: model.viewport.centre, scale: model.viewport.scale },
      computed: [...model.tiles.computed],
    }),
  };
}

/** What only a log has: steps, playing, evidence, parameters. */
function startLog(model: Model, compute: Compute, idle: (() => boolean)[]): Shortcut[] {
  let refresh = (): void => {};
  const broke = (why: string) => {
    player.pause();
    failed(why);
  };
  const stepper = new Stepper(model, broke, () => refresh());
  const evidence = new Evidence(model);
  const shown = () => !evidence.busy && model.tiles.missing === 0;
  const player = new Player(model, stepper, shown, () => refresh());
  const transport = new Transport(model, stepper, player);
  refresh = () => transport.refresh();
  stepper.before = (state) => compute.follow(state);
  compute.nudge = () => void stepper.go({ by: "reading", count: 0 });
  const reading = new ReadingPanel(model);
  evidence.shown = () => reading.open;
  byId("reading-details", HTMLDetailsElement).addEventListener("toggle", () => void evidence.refresh());
  const still = async () => {
    player.pause();
    await stepper.halt();
    await compute.settled();
  };
  const parameters = new Parameters(model);
  const elsewhere = new Elsewhere(model, stepper, broke, notice);
  elsewhere.changing = () => parameters.busy;
  elsewhere.still = () => {
    compute.quit();
    return still();
  };
  parameters.done = () => elsewhere.check();
  parameters.around = async (change) => {
    notice("");
    await still();
    return change();
  };
  const report = () => model.session.mode === "log" && showReport(model.session);
  model.on(["session"], report);
  report();
  announce(model, player);
  idle.push(
    () => !stepper.busy,
    () => !player.playing,
    () => !parameters.busy,
    () => !elsewhere.busy,
    () => !compute.busy,
  );
  return [
    ...MOVES.map((move): Shortcut => ({
      keys: [move.keys.replace(" ", "").replace("←", "ArrowLeft").replace("→", "ArrowRight")],
      shown: move.keys,
      does: move.label.toLowerCase(),
      run: () => transport.move(move),
    })),
    { keys: [" ", "p"], shown: "Space", does: "play, pause, stop", run: () => transport.toggle() },
    ...(["marks", "outline", "follow"] as const).map((what): Shortcut => ({
      keys: [what[0] ?? ""],
      shown: (what[0] ?? "").toUpperCase(),
      does: { marks: "mark the cells of the reading", outline: "outline and robot", follow: "follow the robot" }[what],
      run: () => byId(what, HTMLInputElement).click(),
    })),
    { keys: ["g"], shown: "G", does: "compute in this browser's GPU, or no longer", run: () => void compute.flip(say) },
  ];
}

/** Says where the log stands; while it plays not at every step. */
function announce(model: Model, player: Player): void {
  let last = 0;
  model.on(["state"], () => {
    const now = performance.now();
    if (player.playing && now - last < 4000) return;
    last = now;
    say(position(model));
  });
}

/** Who clicked a button with a pointer goes on with the log's keys: it must not catch the next space. */
function freeFocus(): void {
  document.addEventListener("click", (e) => {
    const control =
      e.target instanceof HTMLElement ? e.target.closest("#tools button, #transport button, #tools input") : null;
    if (e.detail > 0 && control instanceof HTMLElement) control.blur();
  });
}

/** Nothing asked, nothing to draw, for three frames in a row. */
async function settled(idle: (() => boolean)[]): Promise<void> {
  for (let calm = 0; calm < 3;) {
    await new Promise((next) => setTimeout(next, 20));
    await new Promise((next) => requestAnimationFrame(next));
    calm = idle.every((test) => test()) ? calm + 1 : 0;
  }
}

startTheme(() => themed());
api.session().then(start, (e: unknown) => {
  failed(e instanceof Error ? e.message : String(e));
  byId("panels", HTMLDivElement).append(make("p", {}, "There is nothing to show."));
});
