import { useEffect } from "react";
import type { Trace } from "../state/traces";
import { readerOf } from "./messagePath";
import { RingStore } from "./ringStore";
import type { Spans } from "./spans";
import type { TimeRing } from "./timeRing";

/** A curve keeps 65 seconds at 1 kHz. */
const store = new RingStore(2 ** 16, "values");

export const keyOf = ({ topic, path }: Trace): string => `${topic}.${path}`;

/** The values of a curve by time. */
export const valuesOf = (trace: Trace): TimeRing => store.of(keyOf(trace)).ring;

/** When a curve was heard. */
export const heardOf = (trace: Trace): Spans => store.of(keyOf(trace)).heard;

function follow(trace: Trace): () => void {
  const read = readerOf(trace.path);
  return store.follow(keyOf(trace), trace.topic, (ring, message, t_s) => {
    const value = read(message);
    if (value !== undefined) ring.push(t_s, value);
  });
}

/** Hears these curves while the component is mounted. */
export function useTraceValues(traces: readonly Trace[]): void {
  useEffect(() => {
    const leave = traces.map(follow);
    return () => {
      for (const stop of leave) stop();
    };
  }, [traces]);
}
