import { create } from "zustand";
import { useRun } from "./run";

interface TimeWindow {
  /** The length of the plots' common window. */
  length_s: number;
  /** Where a paused window ends; null: it follows the run. Pausing a plot never pauses the run. */
  held_s: number | null;
}

/** The lengths that are offered. */
export const LENGTHS_S = [0.5, 1, 2, 4, 10, 20, 60];
const USUAL_S = 4;

/** The time window that spikes and traces share. */
export const useTimeWindow = create<TimeWindow>(() => ({ length_s: USUAL_S, held_s: null }));

/** Shows at first no more than a run takes, as soon as it is described. */
export function followLength(): void {
  const stop = useRun.subscribe(({ experiment }) => {
    if (!experiment) return;
    stop();
    setWindowLength(
      LENGTHS_S.find((one) => one >= Math.min(experiment.duration_s ?? USUAL_S, USUAL_S)) ?? USUAL_S,
    );
  });
}

export const setWindowLength = (length_s: number): void => useTimeWindow.setState({ length_s });
export const holdWindow = (held_s: number | null): void => useTimeWindow.setState({ held_s });
