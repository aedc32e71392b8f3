// Light or dark: what the system prefers, or what was chosen here last.

import { byId } from "./dom";

const KEPT = "echogrid-theme";
const ORDER = ["auto", "light", "dark"] as const;
type Theme = (typeof ORDER)[number];

// Storage may be forbidden; the page then forgets the choice.
function kept(): Theme {
  try {
    return ORDER.find((t) => t === localStorage.getItem(KEPT)) ?? "auto";
  } catch {
    return "auto";
  }
}

function keep(theme: Theme): void {
  try {
    localStorage.setItem(KEPT, theme);
  } catch {
    // Forgotten, then.
  }
}

export function startTheme(changed: () => void): void {
  const button = byId("theme", HTMLButtonElement);
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  let theme = kept();
  const apply = () => {
    document.documentElement.dataset.theme = theme === "auto" ? (dark.matches ? "dark" : "light") : theme;
    button.textContent = { auto: "◐ Auto", light: "☀ Light", dark: "☾ Dark" }[theme];
    changed();
  };
  button.addEventListener("click", () => {
    theme = ORDER[(ORDER.indexOf(theme) + 1) % ORDER.length] ?? "auto";
    keep(theme);
    apply();
  });
  dark.addEventListener("change", apply);
  apply();
}
