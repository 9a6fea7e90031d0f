import type { Experiment, Status, TimelineData } from "../state/types";

type Snapshot = TimelineData["snapshots"][number];

/** How a time can be reached from here, and the words for it. */
export type Reach =
  | { act: "seek"; t_s: number; says: string }
  | { act: "back"; t_s: number; says: string }
  | { act: "run"; t_s: number; says: string }
  | { act: "restore"; t_s: number; id: string; says: string }
  | { act: "none"; t_s: number; says: string };

export interface Here {
  source: Experiment["source"];
  state: Status["state"];
  t_s: number;
  timestep_s: number;
  snapshots: readonly Snapshot[];
  /** Why nothing can be steered now. */
  blocked: string | undefined;
  /** Why a live run cannot go back in time. */
  noWayBack: string | undefined;
}

export const seconds = (t_s: number): string => `${t_s.toFixed(2)} s`;

/** Whole steps: a run stops between two of them. */
const onStep = (t_s: number, timestep_s: number) =>
  Number((Math.round(t_s / timestep_s) * timestep_s).toFixed(6));

/** What going to a time means: a recording seeks; a live run goes on to a later time, or back to an earlier one. */
export function reach(wanted_s: number, here: Here): Reach {
  const t_s = onStep(Math.max(wanted_s, 0), here.timestep_s);
  const none = (says: string): Reach => ({ act: "none", t_s, says });
  if (here.blocked) return none(here.blocked);
  if (here.source === "recording") return { act: "seek", t_s, says: `Go to ${seconds(t_s)}` };
  const near = (other_s: number) => Math.abs(other_s - t_s) < here.timestep_s / 2;
  if (near(here.t_s)) return none("The run is at this time.");
  const snapshot = here.snapshots.find((one) => !one.left && near(one.t_s));
  if (snapshot) return restoring(snapshot);
  if (t_s < here.t_s)
    return here.noWayBack
      ? none(`The run cannot go back: ${here.noWayBack}.`)
      : { act: "back", t_s, says: `Go back to ${seconds(t_s)}` };
  if (here.state === "finished" || here.state === "failed")
    return none("The run has ended: step back or reset.");
  return { act: "run", t_s, says: `Run to ${seconds(t_s)}` };
}

export const restoring = ({ id, t_s, left }: Snapshot): Reach => ({
  act: "restore",
  t_s,
  id,
  says: left
    ? `Return to the end of the abandoned future at ${seconds(t_s)}`
    : `Restore the snapshot of ${seconds(t_s)}`,
});

const SMALL_S = 0.1;
const LARGE_S = 1;
const moves: Record<string, number> = {
  ArrowRight: SMALL_S,
  ArrowUp: SMALL_S,
  ArrowLeft: -SMALL_S,
  ArrowDown: -SMALL_S,
  PageUp: LARGE_S,
  PageDown: -LARGE_S,
  Home: Number.NEGATIVE_INFINITY,
  End: Number.POSITIVE_INFINITY,
};

/** Where a key takes the slider; null for a key that is none of its own. */
export function reachByKey(key: string, here: Here, end_s: number): Reach | null {
  const move = moves[key];
  if (move === undefined) return null;
  const step_s = Math.sign(move) * Math.max(Math.abs(move), here.timestep_s);
  return reach(Math.min(Math.max(here.t_s + step_s, 0), end_s), here);
}
