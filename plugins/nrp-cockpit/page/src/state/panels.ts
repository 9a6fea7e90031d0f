/** The kinds of panels, and the panels of each kind. */

export const PANELS = [
  "scene",
  "camera",
  "map",
  "brain",
  "spikes",
  "traces",
  "parameters",
  "inspector",
] as const;
export type Kind = (typeof PANELS)[number];

/** A panel: its kind and, from the second of a kind on, a number, as in `camera 2`. */
export type PanelId = Kind | `${Kind} ${number}`;

export const kindOf = (id: PanelId): Kind => id.split(" ")[0] as Kind;
/** Which panel of its kind it is, from 1. */
export const numberOf = (id: PanelId): number => Number(id.split(" ")[1] ?? 1);
