import { create } from "zustand";

/** One curve: a field of a topic by its message path, such as `linear.x` of `/husky/cmd_vel`. */
export interface Trace {
  topic: string;
  path: string;
}

export const useTraces = create<{ traces: readonly Trace[] }>(() => ({ traces: [] }));

/** Adds a curve to the plots, from any room (a drag or a menu). */
export function addTrace(trace: Trace): void {
  const same = (one: Trace) => one.topic === trace.topic && one.path === trace.path;
  useTraces.setState(({ traces }) => (traces.some(same) ? { traces } : { traces: [...traces, trace] }));
}

export function removeTrace(trace: Trace): void {
  useTraces.setState(({ traces }) => ({ traces: traces.filter((one) => one !== trace) }));
}
