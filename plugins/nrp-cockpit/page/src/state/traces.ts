import { create } from "zustand";

/** One curve: a field of a topic by its message path, such as `linear.x` of `/husky/cmd_vel`. */
export interface Trace {
  topic: string;
  path: string;
  /** The panel that it is in, by default the first one with curves. */
  panel?: string;
}

interface Traces {
  traces: readonly Trace[];
  /** Whether a person changed them in this visit, so that they are worth saving. */
  chosen: boolean;
}

export const useTraces = create<Traces>(() => ({ traces: [], chosen: false }));

/** Adds a curve to the plots, from any room (a drag or a menu). */
export function addTrace(trace: Trace): void {
  const { topic, path, panel = "traces" } = trace;
  const same = (one: Trace) => one.topic === topic && one.path === path && (one.panel ?? "traces") === panel;
  useTraces.setState(({ traces }) =>
    traces.some(same) ? { traces } : { traces: [...traces, trace], chosen: true },
  );
}

export function removeTrace(trace: Trace): void {
  useTraces.setState(({ traces }) => ({ traces: traces.filter((one) => one !== trace), chosen: true }));
}

const DRAGGED = "application/x-nrp-trace";

/** Makes a dragged element carry a curve; call it when the drag begins. */
export function dragTrace(data: DataTransfer, { topic, path }: Trace): void {
  data.setData(DRAGGED, JSON.stringify({ topic, path }));
  data.effectAllowed = "copy";
}

export const carriesTrace = (data: DataTransfer): boolean => data.types.includes(DRAGGED);

/** Adds the curve that was dropped on a panel, if one was. */
export function dropTrace(data: DataTransfer, panel: string): void {
  const carried = data.getData(DRAGGED);
  if (carried) addTrace({ ...JSON.parse(carried), panel });
}
