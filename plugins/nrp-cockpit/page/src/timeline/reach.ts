import type { Experiment, Status, TimelineData } from "../state/types";

type Snapshot = TimelineData["snapshots"][number];

/** How a time can be reached from here, and the words for it. */
export type Reach =
  | { act: "seek"; t_s: number; says: string }
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
}

export const seconds = (t_s: number): string => `${t_s.toFixed(2)} s`;

/** Whole steps: a run stops between two of them. */
const onStep = (t_s: number, timestep_s: number) =>
  Number((Math.round(t_s / timestep_s) * timestep_s).toFixed(6));

/** What going to a time means: a recording seeks; a live run goes on to a later time, and back only to a snapshot. */
export function reach(wanted_s: number, here: Here): Reach {
  const t_s = onStep(wanted_s, here.timestep_s);
  const none = (says: string): Reach => ({ act: "none", t_s, says });
  if (here.blocked) return none(here.blocked);
  if (here.source === "recording") return { act: "seek", t_s, says: `Go to ${seconds(t_s)}` };
  const snapshot = here.snapshots.find((one) => Math.abs(one.t_s - t_s) < here.timestep_s / 2);
  if (snapshot) return restoring(snapshot);
  if (t_s <= here.t_s)
    return none(
      here.snapshots.length > 0
        ? "A run goes back only to a snapshot: click one."
        : "A run goes back only to a snapshot, and there is none.",
    );
  if (here.state === "finished" || here.state === "failed")
    return none("The run is over: step back or reset.");
  return { act: "run", t_s, says: `Run to ${seconds(t_s)}` };
}

export const restoring = ({ id, t_s }: Snapshot): Reach => ({
  act: "restore",
  t_s,
  id,
  says: `Restore the snapshot of ${seconds(t_s)}`,
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
};

/** Where a key takes the slider; null for a key that is none of its own. Back in a live run is the snapshot before. */
export function reachByKey(key: string, here: Here, end_s: number): Reach | null {
  const move = moves[key];
  if (key === "End") return reach(end_s, here);
  if (key !== "Home" && move === undefined) return null;
  if (here.source === "recording")
    return reach(Math.max(key === "Home" ? 0 : here.t_s + (move ?? 0), 0), here);
  if (move !== undefined && move > 0) return reach(here.t_s + Math.max(move, here.timestep_s), here);
  const before = here.snapshots
    .filter((one) => one.t_s < here.t_s - here.timestep_s / 2)
    .sort((a, b) => a.t_s - b.t_s);
  const snapshot = key === "Home" ? before[0] : before.at(-1);
  return reach(snapshot?.t_s ?? Math.max(here.t_s - SMALL_S, 0), here);
}
