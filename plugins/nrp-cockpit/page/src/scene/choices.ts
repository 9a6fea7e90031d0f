import { create } from "zustand";
import type { Orbit } from "./orbit";

export type Mode = "orbit" | "follow" | "above";
export type Layer = "trail" | "frustum" | "rays" | "contacts";

interface Choices {
  mode: Mode;
  layers: ReadonlySet<Layer>;
  /** From where the scene was last seen; null: not yet. */
  view: Orbit | null;
}

/** How the person wants to see the scene; kept while its panel is closed or opens in full size. */
export const useChoices = create<Choices>(() => ({
  mode: "orbit",
  layers: new Set(["trail", "frustum", "rays"]),
  view: null,
}));

export const setMode = (mode: Mode): void => useChoices.setState({ mode });
export const keepView = (view: Orbit): void => useChoices.setState({ view });

export function toggleLayer(layer: Layer): void {
  useChoices.setState(({ layers }) => {
    const next = new Set(layers);
    if (!next.delete(layer)) next.add(layer);
    return { layers: next };
  });
}
