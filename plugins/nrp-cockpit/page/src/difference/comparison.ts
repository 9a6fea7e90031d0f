import { create } from "zustand";
import { wire } from "../wire";

export interface Pair<T> {
  name: string;
  one: T | null;
  other: T | null;
}

/** How a second run differs from the first, as the server says it. */
export interface Comparison {
  /** What the two runs are called. */
  labels: [string, string];
  since_s: number;
  /** The distance between the robots of the two now, and over time as [s, m]. */
  distance_m: number;
  distances: [number, number][];
  /** When each kind of difference began; the earliest first. */
  first: { what: "trajectory" | "spikes"; t_s: number }[];
  events: Pair<number>[];
  criteria: Pair<boolean>[];
  spikes: Pair<number>[];
}

export const useComparison = create<{ comparison: Comparison | null }>(() => ({ comparison: null }));

/** Fills the store from the wire, for as long as the page lives. */
export function followComparison(): void {
  wire.subscribe<Comparison | Record<string, never>>("/cockpit/comparison", (said) =>
    useComparison.setState({ comparison: "labels" in said ? (said as Comparison) : null }),
  );
}
