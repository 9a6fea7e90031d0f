import { wire } from "../wire";
import { dismissText, notify } from "./notices";
import { useRun } from "./run";
import type { Vector } from "./types";

export type ResetWhat = "all" | "robot" | "brain" | "world";

/** Why the run could not go on, as long as a notice says so. */
let stuck = "";
/** Commands that move the time. */
const MOVES = new Set(["play", "step", "step_back", "seek", "run_to", "restore", "reset"]);

/** Calls a service of the cockpit; a failure becomes a notice, and the answer null. */
export async function command<T = object>(name: string, request: object = {}): Promise<T | null> {
  const moves = MOVES.has(name);
  try {
    const answer = await wire.call<T>(`/cockpit/${name}`, request);
    if (moves) dismissText(stuck); // the run goes on
    return answer;
  } catch (error) {
    const text = error instanceof Error ? error.message : String(error);
    if (moves) stuck = text;
    notify(text, "bad");
    return null;
  }
}

export const play = () => command("play");
export const pause = () => command("pause");
export const playOrPause = () => (useRun.getState().status?.state === "running" ? pause() : play());
export const step = (n = 1) => command("step", { n });
export const stepBack = () => command("step_back");
export const reset = (what: ResetWhat) => command("reset", { what });
export const setPace = (factor: number | null) => command("pace", { factor });
export const runTo = (t_s: number) => command("run_to", { t_s });
export const seek = (t_s: number) => command("seek", { t_s });
export const takeSnapshot = () => command("snapshot");
export const restore = (id: string) => command("restore", { id });
export const forget = (id: string) => command("forget", { id });
/** Ends a long way to another time where it is. */
export const halt = () => command("halt");
export const record = (folder: string | null) => command("record", { folder });
export const branch = (from: { t_s: number | null } | { id: string }) => command("branch", from);
export const compare = (brain: string | null, world: string | null) => command("compare", { brain, world });
export const compareRecording = (recording: string) => command("compare", { recording });
export const part = () => command("part");
export const publish = (topic: string, value: object) => command("publish", { topic, value });
export const push = (body: string, force_n: Vector, duration_s: number) =>
  command("push", { body, force_n, duration_s });
export const place = (
  body: string,
  position: Vector,
  orientation: readonly [number, number, number, number],
  undoes: number | null = null,
) => command<{ number: number }>("place", { body, position, orientation, undoes });

export async function toggleRecording(): Promise<void> {
  const recording = useRun.getState().status?.recording;
  const answer = await record(recording ? null : "");
  if (recording && answer) notify(`Recorded to ${recording.path}. Share saves it as one HTML file.`);
}
