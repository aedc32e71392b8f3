// Elements: finding and making them. The page's policy allows no inline styles in markup, so what varies is set from
// here.

/** The element of that id; the page is wrong without it. */
export function byId<T extends HTMLElement>(id: string, kind: new () => T): T {
  const found = document.getElementById(id);
  if (!(found instanceof kind)) throw new Error(`no ${kind.name} with the id ${id}`);
  return found;
}

type Attributes = Record<string, string | number | boolean | undefined>;

/** An element with attributes and children; `undefined` and `false` leave an attribute out. */
export function make<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  attributes: Attributes = {},
  ...children: (Node | string)[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === false) continue;
    element.setAttribute(name, value === true ? "" : String(value));
  }
  element.append(...children);
  return element;
}

/** Two columns: what, and its value. */
export function pairs(entries: [string, string | Node][]): HTMLDListElement {
  const list = make("dl", { class: "pairs" });
  for (const [name, value] of entries) list.append(make("dt", {}, name), make("dd", {}, value));
  return list;
}

/** A table in a box that scrolls sideways by itself. */
export function table(head: string[], rows: (string | Node)[][], caption?: string): HTMLElement {
  const made = make("table", {});
  if (caption) made.append(make("caption", {}, caption));
  made.append(make("thead", {}, make("tr", {}, ...head.map((h) => make("th", { scope: "col" }, h)))));
  const body = make("tbody");
  for (const row of rows) body.append(make("tr", {}, ...row.map((cell) => make("td", {}, cell))));
  made.append(body);
  return make("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": caption ?? head.join(", ") }, made);
}

/** Calls `run` once for many calls in a row, `wait` milliseconds after the last. */
export function later(wait: number, run: () => void): () => void {
  let timer = 0;
  return () => {
    clearTimeout(timer);
    timer = window.setTimeout(run, wait);
  };
}
