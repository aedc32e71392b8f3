// Saves a panel as a PNG: exactly the pixels that its canvas shows.

import { make } from "./dom";
import type { Model } from "./model";
import type { Panel, Scene } from "./scene";

function name(model: Model, { id }: Panel): string {
  const source = id === "difference" ? "difference" : (model.source(id)?.name ?? String(id));
  const parts = [model.session.name, source, model.look.view, ...(model.state ? [String(model.state.position)] : [])];
  return `${parts.join("-").replace(/[^\w.-]+/g, "_")}.png`;
}

export function save(model: Model, scene: Scene): void {
  const panel = scene.active;
  if (!panel) return;
  scene.draw();
  panel.canvas.toBlob((blob) => {
    if (!blob) return;
    const link = make("a", { href: URL.createObjectURL(blob), download: name(model, panel) });
    document.body.append(link);
    link.click();
    link.remove();
    setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
  }, "image/png");
}
