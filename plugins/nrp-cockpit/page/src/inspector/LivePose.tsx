import { useEffect, useRef } from "react";
import { type Pose, rollPitchYaw } from "../world/pose";
import { scale } from "../world/scale";
import { world } from "../world/world";
import { Section } from "./Facts";
import { degrees, fixed } from "./numbers";

const CELLS = [
  ["x", "m"],
  ["roll", "°"],
  ["y", "m"],
  ["pitch", "°"],
  ["z", "m"],
  ["yaw", "°"],
] as const;

/** The numbers of a pose in the order of the cells. */
function textsOf({ position: [x, y, z], orientation }: Pose): string[] {
  const [roll, pitch, yaw] = rollPitchYaw(orientation).map(degrees) as [number, number, number];
  const decimals = scale.unit < 0.1 ? 4 : 2;
  const [across, along, up] = [x, y, z].map((value) => fixed(value, decimals)) as [string, string, string];
  return [across, fixed(roll, 1), along, fixed(pitch, 1), up, fixed(yaw, 1)];
}

/** Where a body is now. The numbers are written past React, because they change with every frame. */
export function LivePose({ body }: { body: string }) {
  const grid = useRef<HTMLDListElement>(null);
  useEffect(() => {
    let written: Pose | undefined;
    const write = () => {
      const pose = world.models.get(body);
      const cells = grid.current?.querySelectorAll("b");
      if (!pose || !cells || pose === written) return;
      written = pose;
      textsOf(pose).forEach((text, at) => {
        const cell = cells[at];
        if (cell) cell.textContent = text;
      });
    };
    write();
    return world.follow(write);
  }, [body]);
  return (
    <Section title="Pose" note="in the room">
      <dl ref={grid} className="inspector-pose">
        {CELLS.map(([name, unit]) => (
          <div key={name}>
            <dt>{name}</dt>
            <dd className="num">
              <b>–</b> {unit}
            </dd>
          </div>
        ))}
      </dl>
    </Section>
  );
}
