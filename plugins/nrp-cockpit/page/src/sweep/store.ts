import { create } from "zustand";
import { wire } from "../wire";

interface Measured {
  mean: number | null;
  sd: number | null;
  n: number;
}

/** The runs of one combination of values, over all seeds. */
export interface Group {
  values: Record<string, string | number | boolean | null>;
  runs: number;
  passed: number;
  measured: Record<string, Measured>;
}

export type FigureKind = "curve" | "heat" | "parallel";

/** A sweep, as the server reads it from its folder. */
export interface Sweep {
  name: string;
  folder: string;
  design: string;
  runs: number;
  ended: number;
  failed: number;
  passed: number;
  not_passed: number;
  /** The runs in the table, which is written whenever the command ends. */
  in_table: number;
  keys: { key: string; short: string }[];
  /** The figures that the number of varying settings allows. */
  kinds: FigureKind[];
  measures: string[];
  groups: Group[];
  more_groups: number;
  remarks: string[];
}

interface State {
  /** Whether this page shows a sweep and no run. */
  isOpen: boolean;
  sweep: Sweep | null;
}

export const useSweep = create<State>(() => ({ isOpen: window.location.hash === "#/sweep", sweep: null }));

/** Fills the store from the wire, for as long as the page lives. */
export function followSweep(): void {
  wire.subscribe<Sweep>("/cockpit/sweep", (sweep) => useSweep.setState({ isOpen: true, sweep }));
}
