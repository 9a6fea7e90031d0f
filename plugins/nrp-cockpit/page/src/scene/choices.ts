import { create } from "zustand";
import type { Orbit } from "./orbit";

export type Mode = "orbit" | "follow" | "above";
export type Layer = "trail" | "frustum" | "rays" | "contacts";

interface Choices {
  layers: ReadonlySet<Layer>;
  /** From where the scene was last seen in each panel, by the panel's id. */
  views: Readonly<Record<string, Orbit>>;
}

/** How the person wants to see the scene; kept while its panel is closed or opens in full size. */
export const useChoices = create<Choices>(() => ({
  layers: new Set(["trail", "frustum", "rays"]),
  views: {},
}));

export const keepView = (panel: string, view: Orbit): void =>
  useChoices.setState(({ views }) => ({ views: { ...views, [panel]: view } }));

export function toggleLayer(layer: Layer): void {
  useChoices.setState(({ layers }) => {
    const next = new Set(layers);
    if (!next.delete(layer)) next.add(layer);
    return { layers: next };
  });
}
