import { create } from "zustand";

/** What the person points at; every room shows the same selection. */
export type Selection =
  | { kind: "body"; name: string }
  | { kind: "neuron"; population: string; index: number }
  | { kind: "population"; label: string }
  | { kind: "group"; name: string }
  | { kind: "projection"; id: string }
  | { kind: "function"; name: string };

export const useSelection = create<{ selected: Selection | null }>(() => ({ selected: null }));

export const select = (selected: Selection | null): void => useSelection.setState({ selected });
