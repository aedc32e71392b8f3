// Keys: one table of what each does, from which the dialog is made too.

import { byId, make } from "./dom";
import type { Model } from "./model";
import type { CellPoint } from "./generated/protocol";

export interface Shortcut {
  /** As `Shift+ArrowRight`. */
  keys: string[];
  shown: string;
  does: string;
  run: () => void;
  /** Part of the list only where it does something. */
  when?: boolean;
}

/** Pixels of a step of panning. */
const PAN = 80;

const ARROWS: Record<string, CellPoint> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

function chord(e: KeyboardEvent): string {
  const mods = [e.ctrlKey && "Ctrl", e.metaKey && "Meta", e.altKey && "Alt", e.shiftKey && e.key.length > 1 && "Shift"];
  return [...mods.filter(Boolean), e.key.length === 1 ? e.key.toLowerCase() : e.key].join("+");
}

/** Where keys are for writing, or for the control itself. */
function writes(target: EventTarget | null, key: string): boolean {
  if (!(target instanceof HTMLElement)) return false;
  if (target instanceof HTMLInputElement) {
    if (target.type === "checkbox") return key === " ";
    // The log's slider moves by what the keys mean everywhere else.
    if (target.type === "range") return target.id !== "slider" && /^(Arrow|Page|Home|End)/.test(key);
    return true;
  }
  if (target instanceof HTMLSelectElement || target instanceof HTMLTextAreaElement) return true;
  if (target.closest(".scroll") && /^(Arrow|Page|Home|End)/.test(key)) return true;
  return (
    (key === " " || key === "Enter") &&
    (target instanceof HTMLButtonElement || target.tagName === "SUMMARY" || target.tagName === "A")
  );
}

export class Keys {
  private readonly dialog = byId("keys", HTMLDialogElement);

  constructor(
    private readonly model: Model,
    private readonly shortcuts: Shortcut[],
    private readonly say: (text: string) => void,
    private readonly where: (place: CellPoint) => string,
  ) {
    const rows = [...shortcuts.filter((s) => s.when !== false), ...this.cursor()];
    byId("keys-list", HTMLDListElement).append(
      ...rows.flatMap((s) => [make("dt", {}, make("kbd", {}, s.shown)), make("dd", {}, s.does)]),
    );
    byId("help", HTMLButtonElement).addEventListener("click", () => this.help());
    document.addEventListener("keydown", (e) => this.press(e));
  }

  /** Opens the list, or closes it. */
  help(): void {
    if (this.dialog.open) this.dialog.close();
    else this.dialog.showModal();
  }

  private cursor(): { shown: string; does: string }[] {
    return [
      { shown: "C", does: "cursor on or off: arrow keys then move it by a cell, with Shift by ten" },
      { shown: "Enter", does: "inspect the cell under the cursor" },
      { shown: "Esc", does: "leave the cursor, else stop inspecting" },
      { shown: "Alt+arrows", does: "move the view" },
    ];
  }

  private press(e: KeyboardEvent): void {
    if (e.defaultPrevented || this.dialog.open || writes(e.target, e.key)) return;
    const keys = chord(e);
    if (this.moves(e, keys)) return e.preventDefault();
    const found = this.shortcuts.find((s) => s.when !== false && s.keys.includes(keys));
    if (!found) return;
    e.preventDefault();
    found.run();
  }

  /** The keys of the cursor and of panning. */
  private moves(e: KeyboardEvent, keys: string): boolean {
    const { model } = this;
    const arrow = ARROWS[e.key];
    if (arrow && (e.altKey || (!model.log && !model.cursor)) && !e.ctrlKey && !e.metaKey) {
      model.viewport.pan(-arrow[0] * PAN, arrow[1] * PAN);
      return true;
    }
    if (keys === "c") {
      const { grid } = model.session;
      const [column, row] = (model.picked ?? model.viewport.centre).map(Math.floor) as CellPoint;
      this.put(model.cursor ? null : [Math.min(column, grid.width - 1), Math.min(row, grid.height - 1)]);
      return true;
    }
    if (keys === "Escape") {
      if (model.cursor) this.put(null);
      else model.pick(null);
      return true;
    }
    if (!model.cursor) return false;
    if (keys === "Enter") {
      model.pick(model.cursor);
      return true;
    }
    if (!arrow || e.ctrlKey || e.metaKey) return false;
    const far = e.shiftKey ? 10 : 1;
    const next: CellPoint = [model.cursor[0] + arrow[0] * far, model.cursor[1] + arrow[1] * far];
    if (model.inside(next)) this.put(next);
    return true;
  }

  private put(place: CellPoint | null): void {
    this.model.cursor = place;
    this.model.hover = null;
    if (place) this.model.viewport.show([place[0] + 0.5, place[1] + 0.5]);
    this.say(place ? this.where(place) : "cursor off");
    this.model.tell("hover");
    this.model.tell("view");
  }
}
