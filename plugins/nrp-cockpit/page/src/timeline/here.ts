import { blockedBy, missingOf, useRun } from "../state/run";
import type { Here } from "./reach";

/** Where the run is and what it can do now. Read at an event, so that no render follows the running time. */
export function here(): Here {
  const run = useRun.getState();
  return {
    source: run.experiment?.source ?? "live",
    state: run.status?.state ?? "paused",
    t_s: run.status?.t_s ?? 0,
    timestep_s: run.experiment?.timestep_s ?? 0.02,
    snapshots: run.timeline?.snapshots ?? [],
    blocked: blockedBy(run),
    noWayBack: missingOf(run, "step_back"),
  };
}
