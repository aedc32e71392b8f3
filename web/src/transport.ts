// The buttons of the steps, the slider over the log, play and pause.

import { byId, make } from "./dom";
import { count, seconds } from "./format";
import type { Model } from "./model";
import type { Player } from "./player";
import type { Stepper } from "./stepper";

export interface Move {
  id: string;
  text: string;
  label: string;
  keys: string;
  run: (stepper: Stepper, model: Model) => void;
}

const by = (unit: "reading" | "scan", n: number) => (stepper: Stepper) => void stepper.go({ by: unit, count: n });

/** Every step, back and forth; keys.ts gives the same to keys. */
export const MOVES: Move[] = [
  { id: "to-start", text: "Start", label: "To the start", keys: "Home", run: (s) => void s.go({ to: 0 }) },
  { id: "back-10-scans", text: "−10 scans", label: "Ten scans back", keys: "Page Up", run: by("scan", -10) },
  { id: "back-scan", text: "−1 scan", label: "One scan back", keys: "Shift+←", run: by("scan", -1) },
  { id: "back-reading", text: "−1", label: "One reading back", keys: "←", run: by("reading", -1) },
  { id: "on-reading", text: "+1", label: "One reading on", keys: "→", run: by("reading", 1) },
  { id: "on-scan", text: "+1 scan", label: "One scan on", keys: "Shift+→", run: by("scan", 1) },
  { id: "on-10-scans", text: "+10 scans", label: "Ten scans on", keys: "Page Down", run: by("scan", 10) },
  {
    id: "to-end",
    text: "Rest",
    label: "The rest of the log",
    keys: "End",
    run: (s, m) => void s.go({ to: m.state?.total ?? 0 }),
  },
];

/** Where in the log it stands, in words. */
export function position(model: Model): string {
  const { state } = model;
  if (!state) return "";
  const current = state.lanes[0]?.current;
  const scans = `scan ${count(state.scan)} of ${count(state.scans)}`;
  // Of a counting sensor model a step is a scan.
  if (model.countsScans(0)) return scans;
  const t = current && current.t !== null ? ` · t = ${seconds(current.t)}` : "";
  return `reading ${count(state.position)} of ${count(state.total)} · ${scans}${t}`;
}

export class Transport {
  private readonly slider = byId("slider", HTMLInputElement);
  private readonly text = byId("position", HTMLOutputElement);
  private readonly play = byId("play", HTMLButtonElement);
  private readonly rate = byId("rate", HTMLInputElement);
  private readonly by = byId("rate-by", HTMLSelectElement);

  constructor(
    private readonly model: Model,
    private readonly stepper: Stepper,
    private readonly player: Player,
  ) {
    const [back, on] = [byId("moves-back", HTMLDivElement), byId("moves-on", HTMLDivElement)];
    MOVES.forEach((move, k) => {
      const title = `${move.label} (${move.keys})`;
      const button = make("button", { id: move.id, type: "button", title, "aria-label": move.label }, move.text);
      button.addEventListener("click", () => this.move(move));
      (k < 4 ? back : on).append(button);
    });
    this.slider.addEventListener("input", () => {
      // Pausing refreshes the slider: its value is taken before.
      const to = Number(this.slider.value);
      player.pause();
      void stepper.go({ to });
    });
    this.play.addEventListener("click", () => this.toggle());
    for (const field of [this.rate, this.by]) field.addEventListener("change", () => this.speed());
    model.on(["state", "session"], () => this.refresh());
    this.speed();
    this.refresh();
  }

  move(move: Move): void {
    if (this.player.playing) this.player.pause();
    move.run(this.stepper, this.model);
  }

  /** Plays or pauses; a long way under way is stopped. */
  toggle(): void {
    if (!this.player.playing && this.stepper.going) this.stepper.stop();
    else this.player.toggle();
  }

  private speed(): void {
    this.player.rate = Math.min(100000, Math.max(0.1, Number(this.rate.value) || 1));
    this.player.by = this.by.value === "reading" ? "reading" : "scan";
  }

  refresh(): void {
    const { state } = this.model;
    if (!state) return;
    this.slider.max = String(state.total);
    if (document.activeElement !== this.slider || !this.stepper.busy) this.slider.value = String(state.position);
    const text = position(this.model);
    this.slider.setAttribute("aria-valuetext", text);
    this.text.value = text;
    const running = this.player.playing || this.stepper.going;
    this.play.textContent = running ? "❚❚ Pause" : "▶ Play";
    this.play.setAttribute("aria-pressed", String(running));
    document.body.classList.toggle("busy", this.stepper.busy);
  }
}
