import { create } from "zustand";

interface TimeWindow {
  /** The length of the plots' common window. */
  length_s: number;
  /** Where a paused window ends; null: it follows the run. Pausing a plot never pauses the run. */
  held_s: number | null;
}

/** The time window that spikes and traces share. */
export const useTimeWindow = create<TimeWindow>(() => ({ length_s: 4, held_s: null }));

export const setWindowLength = (length_s: number): void => useTimeWindow.setState({ length_s });
export const holdWindow = (held_s: number | null): void => useTimeWindow.setState({ held_s });
