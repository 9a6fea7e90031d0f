import { describe, expect, it } from "vitest";
import type { Entity } from "../world/entities";
import { IDENTITY, type Pose } from "../world/pose";
import { Plan } from "./plan";

const grey = { r: 0.5, g: 0.5, b: 0.5, a: 1 };
const red = { r: 1, g: 0, b: 0, a: 1 };

const at = (z: number): Pose => ({ position: [0, 0, z], orientation: [0, 0, 0, 1] });

const box = (
  body: string,
  size: [number, number, number],
  z: number,
  color = grey,
  frame = "world",
): Entity => ({
  id: `${body}/link/visual`,
  body,
  frame,
  shapes: [{ kind: "cube", size, pose: at(z), color, mesh: null }],
});

const planOf = (...entities: Entity[]) => {
  const plan = new Plan();
  plan.read(new Map(entities.map((one) => [one.id, one])), () => IDENTITY);
  return plan;
};

describe("the plan of a room", () => {
  it("leaves out ceilings and endless ground", () => {
    const plan = planOf(
      box("ground", [100, 100, 0.002], 0),
      box("ceiling", [8, 8, 0.1], 3),
      box("wall", [8, 0.2, 3], 1.5),
    );
    expect(plan.still.map(({ body }) => body)).toEqual(["wall"]);
  });

  it("draws from below, and strong colours last", () => {
    const plan = planOf(
      box("frame", [1, 1, 2], 1),
      box("glass", [1, 1, 1], 0.5, red),
      box("floor", [8, 8, 0.1], -0.05, red),
    );
    expect(plan.still.map(({ body }) => body)).toEqual(["floor", "frame", "glass"]);
  });

  it("places what moves where its frame is now", () => {
    const plan = planOf(box("husky", [1, 1, 1], 0, grey, "husky/base"));
    expect(plan.still).toEqual([]);
    const [one] = plan.moving(() => ({ position: [5, 0, 0], orientation: [0, 0, 0, 1] }));
    expect(one?.outline.map(([x]) => x)).toEqual(expect.arrayContaining([4.5, 5.5]));
  });
});
