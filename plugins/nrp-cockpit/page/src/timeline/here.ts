import { barredBy, blockedBy, missingOf, useRun } from "../state/run";
import type { Here } from "./reach";

/** Where the run is and what it can do now. Read at an event, so that no render follows the running time. */
export function here(): Here {
  const run = useRun.getState();
  const source = run.experiment?.source ?? "live";
  return {
    source,
    state: run.status?.state ?? "paused",
    t_s: run.status?.t_s ?? 0,
    timestep_s: run.experiment?.timestep_s ?? 0.02,
    snapshots: run.timeline?.snapshots ?? [],
    blocked: source === "recording" ? barredBy(run) : blockedBy(run), // a drag seeks while it is busy seeking
    noWayBack: missingOf(run, "step_back"),
  };
}
