import { create } from "zustand";
import { isEmbedded } from "../state/view";
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

/** Where a page keeps the first view of the first of two compared runs. */
const FIRST = "nrp-cockpit-first-view";

/** The first view of a run: of two that are compared, that of the other one if it has begun. */
export function firstView(own: Orbit): Orbit {
  if (!isEmbedded(window.location)) return own;
  const other = sessionStorage.getItem(FIRST);
  if (other) return JSON.parse(other) as Orbit;
  sessionStorage.setItem(FIRST, JSON.stringify(own));
  return own;
}

/** Lets two runs begin with a view of their own again. */
export const forgetFirstView = (): void => sessionStorage.removeItem(FIRST);

export function toggleLayer(layer: Layer): void {
  useChoices.setState(({ layers }) => {
    const next = new Set(layers);
    if (!next.delete(layer)) next.add(layer);
    return { layers: next };
  });
}
