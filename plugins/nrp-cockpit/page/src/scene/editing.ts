import { create } from "zustand";
import { LatestOnly } from "../parameters/numbers";
import { command, place } from "../state/commands";
import { useRun } from "../state/run";
import { select } from "../state/selection";
import type { Body, Vector } from "../state/types";
import { fromRollPitchYaw, multiply, type Pose, yawOf } from "../world/pose";
import { scale } from "../world/scale";
import { world } from "../world/world";

/** A change of the room that can be undone: what it was, and what takes it back. */
interface Step {
  text: string;
  takeBack: () => Promise<unknown>;
}

interface Editing {
  isOn: boolean;
  /** What the next click adds; null: a click selects. */
  adding: string | null;
  /** The body that keys move, and where it goes; null: the server has answered. */
  moved: { body: string; pose: Pose } | null;
  /** Where the body is that was moved last, in words. */
  said: string;
  steps: readonly Step[];
}

/** Whether bodies are moved and added, and what was done so far. */
export const useEditing = create<Editing>(() => ({
  isOn: false,
  adding: null,
  moved: null,
  said: "",
  steps: [],
}));

const { getState: get, setState: set } = useEditing;

export const toggleEditing = (): void => set(({ isOn }) => ({ isOn: !isOn, adding: null, moved: null }));
export const beginToAdd = (adding: string | null): void => set({ adding });
export const say = (body: string, pose: Pose): void => set({ said: `${body}: ${poseText(pose)}` });

/** Where a body is now; undefined: it is not known. */
export function poseOf(body: string): Pose | undefined {
  return world.models.get(body) ?? bodyOf(body)?.pose ?? undefined;
}

const bodyOf = (name: string): Body | undefined =>
  useRun.getState().experiment?.bodies.find((body) => body.name === name);

export const isStatic = (body: string): boolean => bodyOf(body)?.static ?? false;

/** A pose moved along the ground and turned about the vertical through its own origin; m and rad. */
export function shifted({ position: [x, y, z], orientation }: Pose, by: Shift): Pose {
  return {
    position: [x + by.x, y + by.y, z],
    orientation: multiply(fromRollPitchYaw(0, 0, by.yaw), orientation),
  };
}

export interface Shift {
  x: number;
  y: number;
  yaw: number;
}

/** Where a body is on the ground, in words. */
export function poseText({ position: [x, y], orientation }: Pose): string {
  const decimals = scale.unit < 0.1 ? 4 : 2;
  const degrees = (yawOf(orientation) * 180) / Math.PI;
  return `x ${x.toFixed(decimals)} m, y ${y.toFixed(decimals)} m, ${degrees.toFixed(0)}°`;
}

/** Puts a body elsewhere, between two steps; it is at rest there. */
export async function put(body: string, pose: Pose): Promise<void> {
  const before = poseOf(body);
  const answer = await place(body, [...pose.position] as Vector, pose.orientation);
  if (answer && before)
    done({
      text: `Put ${body} back`,
      takeBack: () => place(body, [...before.position] as Vector, before.orientation, answer.number),
    });
}

/** The side of a shape that is added in a usual room (m). */
const SIZE_M = 0.4;

/** Adds a body that stands at a point of the ground, and selects it. */
export async function addAt(model: string, position: Vector): Promise<void> {
  set({ adding: null });
  const size_m = SIZE_M * scale.unit;
  const answer = await command<{ body: string }>("bodies/add", { model, position, size_m });
  if (!answer) return;
  const { body } = answer;
  select({ kind: "body", name: body });
  done({ text: `Remove ${body}`, takeBack: () => command("bodies/remove", { body }) });
}

const MOST_STEPS = 100;
const done = (step: Step): void => set(({ steps }) => ({ steps: [...steps, step].slice(-MOST_STEPS) }));

export async function undoStep(): Promise<void> {
  const last = get().steps.at(-1);
  if (!last) return;
  set(({ steps }) => ({ steps: steps.slice(0, -1) }));
  await last.takeBack();
}

const latest = new LatestOnly();

/** Moves a body by a key: where it goes is shown at once, and the keys that follow add to that. */
export function nudge(body: string, by: Shift): void {
  const { moved } = get();
  const from = moved?.body === body ? moved.pose : poseOf(body);
  if (!from) return;
  const pose = shifted(from, by);
  set({ moved: { body, pose } });
  say(body, pose);
  void latest.ask(async () => {
    await put(body, pose);
    set((now) => (now.moved?.pose === pose ? { moved: null } : {}));
  });
}

const KEY_M = 0.1;
const KEY_RAD = Math.PI / 36;
const ARROWS: Readonly<Record<string, readonly [toRight: number, away: number]>> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, 1],
  ArrowDown: [0, -1],
};

/**
 * What an arrow does to the selected body: it moves along the axis of the room that is nearest to the arrow as
 * seen from this azimuth (rad); with Shift, left and right turn it.
 */
export function shiftOf(key: string, shiftKey: boolean, azimuth: number): Shift | null {
  const arrow = ARROWS[key];
  if (!arrow) return null;
  const [toRight, away] = arrow;
  if (shiftKey) return toRight === 0 ? null : { x: 0, y: 0, yaw: -toRight * KEY_RAD };
  const quarter = Math.round(azimuth / (Math.PI / 2)) * (Math.PI / 2);
  const [cos, sin] = [Math.round(Math.cos(quarter)), Math.round(Math.sin(quarter))];
  const step_m = KEY_M * scale.unit;
  return { x: step_m * (-sin * toRight - cos * away), y: step_m * (cos * toRight - sin * away), yaw: 0 };
}
