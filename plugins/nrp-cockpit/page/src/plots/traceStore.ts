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

/** Its values in the future that the run abandoned. */
export const leftOf = (trace: Trace): TimeRing | undefined => store.of(keyOf(trace)).left;

/** When a curve was heard. */
export const heardOf = (trace: Trace): Spans => store.of(keyOf(trace)).heard;

/** Adds the number at a path of each message to a ring. */
export function addValue(path: string, ring: TimeRing): (message: unknown, t_s: number) => void {
  const read = readerOf(path);
  return (message, t_s) => {
    const value = read(message);
    if (value !== undefined) ring.push(t_s, value);
  };
}

const follow = (trace: Trace): (() => void) =>
  store.follow(keyOf(trace), trace.topic, (ring) => addValue(trace.path, ring));

/** Hears these curves while the component is mounted. */
export function useTraceValues(traces: readonly Trace[]): void {
  useEffect(() => {
    const leave = traces.map(follow);
    return () => {
      for (const stop of leave) stop();
    };
  }, [traces]);
}
