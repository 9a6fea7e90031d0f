import { useEffect, useState } from "react";
import { create } from "zustand";
import { type Link, wire } from "../wire";
import { keepSame } from "./same";
import type { Experiment, Finding, Functions, Status, TimelineData } from "./types";

interface LogLine {
  t_s: number;
  level: string;
  text: string;
}

export interface Run {
  link: Link;
  experiment: Experiment | null;
  status: Status | null;
  functions: Functions | null;
  timeline: TimelineData | null;
  findings: readonly Finding[];
  log: readonly LogLine[];
}

const LOG_LINES = 500;

/** What the server last said about the run; null until it said it. The page computes none of it. */
export const useRun = create<Run>(() => ({
  link: { state: "connecting" },
  experiment: null,
  status: null,
  functions: null,
  timeline: null,
  findings: [],
  log: [],
}));

/** Fills the store from the wire, for as long as the page lives. */
export function followRun(): void {
  const set = useRun.setState;
  wire.onLink((link) => set({ link }));
  wire.subscribe<Experiment>("/cockpit/experiment", (experiment) =>
    set((run) => ({ experiment: keepSame(run.experiment, experiment) })),
  );
  wire.subscribe<Status>("/cockpit/status", (status) => set({ status }), "latest");
  wire.subscribe<Functions>("/cockpit/functions", (functions) => set({ functions }));
  wire.subscribe<TimelineData>("/cockpit/timeline", (timeline) => set({ timeline }));
  wire.subscribe<Finding[]>("/cockpit/findings", (findings) => set({ findings }));
  wire.subscribe<LogLine>("/cockpit/log", (line) =>
    set(({ log }) => ({ log: [...log.slice(1 - LOG_LINES), line] })),
  );
}

/** Why this page cannot steer the run, or undefined when it can. */
export function barredBy({ link, experiment, status }: Run): string | undefined {
  if (link.state !== "open") return "The connection to the server is lost.";
  if (!experiment || !status) return "The server has not described the run yet.";
  if (!experiment.may_steer) return "You can watch this run, but not control it.";
  return undefined;
}

/** Why the run cannot be steered at this moment, or undefined when it can. */
export const blockedBy = (run: Run): string | undefined =>
  barredBy(run) ?? (run.status?.state === "busy" ? "The run is busy." : undefined);

/** Why the run cannot be steered now, or undefined when it can. */
export const useBlocked = (): string | undefined => useRun(blockedBy);

/** Why a capability is missing ("snapshot", ...), or undefined when the run has it. */
export function missingOf({ experiment }: Pick<Run, "experiment">, capability: string): string | undefined {
  const has = experiment?.capabilities[capability];
  return typeof has === "string" ? has : undefined;
}

export const useMissing = (capability: string): string | undefined =>
  useRun((run) => missingOf(run, capability));

/** Whether the page shows a recording, which nobody can change. */
export const useRecorded = (): boolean => useRun((run) => run.experiment?.source === "recording");

/** How often time went back, or the run began anew. */
export function useTimesBack(): number {
  const [times, setTimes] = useState(0);
  useEffect(
    () =>
      useRun.subscribe(({ status }, before) => {
        if (status && before.status && status.t_s < before.status.t_s) setTimes((count) => count + 1);
      }),
    [],
  );
  return times;
}
