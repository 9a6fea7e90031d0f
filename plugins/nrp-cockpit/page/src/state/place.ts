import { create } from "zustand";
import { openView } from "./view";

/** A line of a source file, counted from 1. */
export interface Place {
  file: string;
  line: number;
}

/** The place that the editor should show next; null once it did. */
export const usePlace = create<{ asked: Place | null }>(() => ({ asked: null }));

/** Opens the functions at a line, from any room. */
export function openPlace(asked: Place): void {
  usePlace.setState({ asked });
  openView("functions");
}
