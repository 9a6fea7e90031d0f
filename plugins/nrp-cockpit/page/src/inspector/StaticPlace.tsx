import { useSyncExternalStore } from "react";
import { type Extent, extentOf } from "../map/footprint";
import { world } from "../world/world";
import { Fact, Facts, Section } from "./Facts";
import { fixed } from "./numbers";

const follow = (changed: () => void) => world.follow((change) => change === "scene" && changed());

const range = ([from, to]: readonly [number, number]) => `${fixed(from, 2)} to ${fixed(to, 2)} m`;

/** The room that a body takes that never moves. */
function describe(extent: Extent | null): string {
  return extent === null ? "" : [extent.x, extent.y, extent.z].map(range).join("|");
}

/** Where a body is that never moves: how far its shapes reach. */
export function StaticPlace({ body }: { body: string }) {
  const text = useSyncExternalStore(follow, () =>
    describe(
      extentOf(
        [...world.entities.values()].filter((entity) => entity.body === body),
        (frame) => world.frame(frame),
      ),
    ),
  );
  const [x, y, z] = text.split("|");
  if (!x) return null;
  return (
    <Section title="Place" note="fixed to the room">
      <Facts>
        <Fact name="x">{x}</Fact>
        <Fact name="y">{y}</Fact>
        <Fact name="z">{z}</Fact>
      </Facts>
    </Section>
  );
}
