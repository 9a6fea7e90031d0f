import { type Entities, type Entity, WORLD_FRAME } from "../world/entities";
import type { Pose } from "../world/pose";
import { contains, type Footprint, footprintsOf, type Point } from "./footprint";

/** Shapes that hang higher than this (m) would hide the room. */
const CEILING_M = 2;
/** Shapes wider than this (m) stand for endless ground. */
const ENDLESS_M = 50;

/** Whether a footprint is drawn: ceilings and endless ground are not. */
function drawn({ bottom_m, outline }: Footprint): boolean {
  const extent = (axis: 0 | 1) => {
    const values = outline.map((point) => point[axis]);
    return Math.max(...values) - Math.min(...values);
  };
  return bottom_m < CEILING_M && Math.max(extent(0), extent(1)) < ENDLESS_M;
}

const fromBelow = (a: Footprint, b: Footprint) => a.top_m - b.top_m;

/** Lower than this (m), flat things on the ground are its surface. */
const GROUND_M = 0.05;

export const isGround = ({ top_m }: Footprint): boolean => top_m < GROUND_M;

/** Whether a thing has a strong colour: a screen is known by that, not by the upper edge of its frame. */
const isVivid = (one: Footprint): boolean =>
  !isGround(one) &&
  Math.max(one.color.r, one.color.g, one.color.b) - Math.min(one.color.r, one.color.g, one.color.b) > 0.8;

/** The order in which footprints are drawn: from below, the vivid ones last. */
const inOrder = (a: Footprint, b: Footprint) => Number(isVivid(a)) - Number(isVivid(b)) || fromBelow(a, b);

/** The footprints of a scene: those that stay are computed once, those that move whenever they are asked for. */
export class Plan {
  still: readonly Footprint[] = [];
  private movable: readonly Entity[] = [];

  read(entities: Entities, poseOf: (frame: string) => Pose): void {
    const all = [...entities.values()];
    this.movable = all.filter(({ frame }) => frame !== WORLD_FRAME);
    this.still = all
      .filter(({ frame }) => frame === WORLD_FRAME)
      .flatMap((entity) => footprintsOf(entity, poseOf(entity.frame)))
      .filter(drawn)
      .sort(inOrder);
  }

  moving(poseOf: (frame: string) => Pose): Footprint[] {
    return this.movable
      .flatMap((entity) => footprintsOf(entity, poseOf(entity.frame)))
      .filter(drawn)
      .sort(inOrder);
  }
}

/** The body seen at a place: that of the highest footprint there. */
export function bodyAt(footprints: readonly Footprint[], place: Point): string | null {
  const there = footprints.filter(({ outline }) => contains(outline, place));
  return there.toSorted(fromBelow).at(-1)?.body ?? null;
}
