import type { Body } from "../state/types";
import type { Rgba } from "../world/messages";

export interface NamedColor {
  name: string;
  color: Rgba;
}

const opaque = (r: number, g: number, b: number): Rgba => ({ r, g, b, a: 1 });

/** The colours that one click gives. */
export const SWATCHES: readonly NamedColor[] = [
  { name: "Red", color: opaque(1, 0, 0) },
  { name: "Blue", color: opaque(0, 0, 1) },
  { name: "Green", color: opaque(0, 1, 0) },
  { name: "White", color: opaque(1, 1, 1) },
];

const byte = (value: number) =>
  Math.round(Math.min(Math.max(value, 0), 1) * 255)
    .toString(16)
    .padStart(2, "0");

/** As `#rrggbb`, which leaves the opacity out. */
export const toHex = ({ r, g, b }: Rgba): string => `#${byte(r)}${byte(g)}${byte(b)}`;

/** Of `#rrggbb`. */
export function fromHex(hex: string): Rgba {
  const part = (at: number) => Number.parseInt(hex.slice(at, at + 2), 16) / 255;
  return opaque(part(1), part(3), part(5));
}

/** A part of a body that a topic colours: the id of its entity in the scene. */
export interface ColoredPart {
  topic: string;
  entity: string;
}

/** `/model/link/visual/color` colours the entity `model/link/visual`. */
const entityOfTopic = (topic: string): string => topic.replace(/^\//, "").replace(/\/color$/, "");

/** The parts of a body that can be coloured, the one that the experiment names first. */
export function coloredParts({ topics, colorable, colored_part }: Body): ColoredPart[] {
  const all = topics
    .filter((topic) => topic.endsWith("/color"))
    .map((topic) => ({ topic, entity: entityOfTopic(topic) }));
  if (colorable === null || colored_part === null) return all;
  const others = all.filter(({ entity }) => entity !== colored_part);
  return [{ topic: colorable, entity: colored_part }, ...others];
}
