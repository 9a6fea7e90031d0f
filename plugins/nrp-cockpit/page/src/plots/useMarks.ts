import { useMemo } from "react";
import { useRun } from "../state/run";

interface Mark {
  name: string;
  t_s: number | null;
}

/** What is marked on the time axis of plots: events, and changes by hand, in the order of time. */
export function useMarks(): readonly Mark[] {
  const events = useRun((run) => run.timeline?.events);
  const edits = useRun((run) => run.timeline?.edits);
  return useMemo(() => {
    const all: Mark[] = [...(events ?? []), ...(edits ?? [])];
    return all.sort((a, b) => (a.t_s ?? 0) - (b.t_s ?? 0));
  }, [events, edits]);
}
