import { valueText } from "../plots/timeAxis";
import type { Experiment } from "../state/types";
import type { Box, WireData } from "./types";

/** What goes through a wire: the messages of a topic, or the values of a device of the run. */
export type Carried = { topic: string } | { device: string };

const TOPIC = "topic:";

/** What a wire of functions carries; null: what does not exist in a run by itself. */
export function carriedBy({ source_end, target_end }: WireData, boxes: readonly Box[]): Carried | null {
  for (const end of [source_end, target_end]) {
    if (end.startsWith(TOPIC)) return { topic: end.slice(TOPIC.length) };
    const row = boxes.flatMap(({ rows }) => rows ?? []).find(({ path }) => path === end);
    if (row?.kind === "device" && row.device) return { device: row.device };
  }
  return null;
}

/** Where the values of a wire are heard, in which unit; a rate is known without hearing anything. */
export interface Source {
  topics: readonly string[];
  unit: string;
  rate_hz: number | null;
}

/** Of so many devices of a group the values are shown, and of so many numbers of a message. */
const MOST = 3;
/** Messages that would cost much and say little as numbers. */
const LARGE = /(Image|PointCloud2?|EventArray|EventPacket|ModelStates|LinkStates)$/;

/** Where the run says what a wire carries; null: it does not, as for what is drawn and does not run yet. */
export function sourceOf(
  carried: Carried | null,
  { topics, devices }: Pick<Experiment, "topics" | "devices">,
): Source | null {
  if (carried === null) return null;
  if ("topic" in carried) {
    const topic = topics.find(({ name }) => name === carried.topic);
    if (!topic) return null;
    if (LARGE.test(topic.type)) return { topics: [], unit: "", rate_hz: topic.rate_hz };
    return { topics: [topic.name], unit: topic.unit ?? "", rate_hz: null };
  }
  const found = devices.filter(
    ({ name }) => name === carried.device || name.startsWith(`${carried.device}/`),
  );
  const [first] = found;
  if (!first) return null;
  return { topics: found.slice(0, MOST + 1).map(({ topic }) => topic), unit: first.unit, rate_hz: null };
}

const NOTHING = "–";

/** The latest messages of the topics of a wire, in a few characters; what moves of a velocity in a line each. */
export function textOf(messages: readonly unknown[], unit: string): string {
  const twist = twistIn(messages[0]);
  if (twist) return velocityText(twist);
  const found = messages.flatMap((message) => leavesOf(message, MOST + 1));
  if (found.length === 0) return NOTHING;
  const shown = found.slice(0, MOST).map((leaf) => (typeof leaf === "string" ? leaf : shortText(leaf)));
  return [...shown, found.length > MOST && "…", unit].filter(Boolean).join(" ");
}

/** Beside values of this size the rest of a decay is about 0. */
const SMALL = 1e-3;
const shortText = (value: number): string => (value === 0 ? "0" : valueText(value, SMALL));

type Vector = Record<"x" | "y" | "z", number>;
interface Twist {
  linear: Vector;
  angular: Vector;
}

/** The velocity that a message consists of, perhaps beside its header. */
function twistIn(message: unknown): Twist | null {
  const fields = (message ?? {}) as Partial<Twist & { twist: unknown; pose: unknown }>;
  if (fields.linear && fields.angular) return fields as Twist;
  return fields.twist && !fields.pose ? twistIn(fields.twist) : null;
}

/** The speed along x and the turn about z, which wheels have, and all other components that are not 0. */
function velocityText({ linear, angular }: Twist): string {
  const components = [
    ["vx", linear.x], ["vy", linear.y], ["vz", linear.z],
    ["ωx", angular.x], ["ωy", angular.y], ["ωz", angular.z],
  ] as const; // biome-ignore format: a table
  const moving = components.filter(([name, value]) => name === "vx" || name === "ωz" || value !== 0);
  const lines = moving.slice(0, MOST).map(([name, value]) => `${name} ${shortText(value)}`);
  return [...lines, ...(moving.length > MOST ? ["…"] : [])].join("\n");
}

export const rateText = (rate_hz: number | null): string =>
  rate_hz === null ? NOTHING : `${Number(rate_hz.toPrecision(3))} Hz`;

/** The mean width of a letter at a wire, and how far a text may reach over the ends of its wire. */
const LETTER_PX = 6.2;
const OVER_PX = 8;

/** Of each line of a value as many whole words as have room: a number that is cut would be another one. */
export const fitted = (text: string, room_px: number): string =>
  text
    .split("\n")
    .map((line) => fittedLine(line, room_px))
    .join("\n");

function fittedLine(text: string, room_px: number): string {
  const words = text.split(" ");
  const fits = (shown: readonly string[]) => shown.join(" ").length * LETTER_PX <= room_px + OVER_PX;
  if (fits(words)) return text;
  const kept = words.filter((word) => word !== "…");
  while (kept.length > 0 && !fits([...kept, "…"])) kept.pop();
  return [...kept, "…"].join(" ");
}

/** The numbers and words of a message in their order, at most so many; not its header, nor the layout of an array. */
function leavesOf(value: unknown, most: number): (number | string)[] {
  if (typeof value === "number" || typeof value === "string") return [value];
  if (typeof value === "bigint" || typeof value === "boolean") return [Number(value)];
  const found: (number | string)[] = [];
  for (const one of partsOf(value)) {
    if (found.length >= most) break;
    found.push(...leavesOf(one, most - found.length));
  }
  return found;
}

function partsOf(value: unknown): Iterable<unknown> {
  if (ArrayBuffer.isView(value)) return value as unknown as Iterable<unknown>;
  if (Array.isArray(value)) return value;
  const fields = Object.entries(value ?? {}).filter(([name]) => name !== "header" && name !== "layout");
  return fields.map(([, field]) => field);
}
