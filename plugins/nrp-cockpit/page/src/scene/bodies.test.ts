import { Vector3 } from "three";
import { expect, it } from "vitest";
import type { Entity } from "../world/entities";
import { fromRollPitchYaw, IDENTITY } from "../world/pose";
import { Bodies } from "./bodies";

const red = { r: 1, g: 0, b: 0, a: 1 };

const box = (id: string, frame: string, x: number): Entity => ({
  id,
  body: id.split("/")[0] ?? "",
  frame,
  shapes: [
    { kind: "cube", size: [2, 2, 2], color: red, mesh: null, pose: { ...IDENTITY, position: [x, 0, 0] } },
  ],
});

const known = (...all: Entity[]) => new Map(all.map((one) => [one.id, one]));
const centreOf = (bodies: Bodies, body: string) => bodies.boxOf(bodies.of(body)).getCenter(new Vector3());

it("a shape stands where its frame and its own pose put it", () => {
  const bodies = new Bodies();
  bodies.show(known(box("husky/base/deck", "husky/base", 1)));
  bodies.move(() => ({ position: [10, 0, 5], orientation: fromRollPitchYaw(0, 0, Math.PI / 2) }));
  bodies.root.updateMatrixWorld();
  const { x, y, z } = centreOf(bodies, "husky");
  expect([x, y, z].map((value) => Number(value.toFixed(6)))).toEqual([10, 1, 5]);
});

it("an entity that stays the same keeps its mesh, one that goes loses it", () => {
  const bodies = new Bodies();
  const [wall, husky] = [box("room/wall/a", "world", 0), box("husky/base/deck", "husky/base", 0)];
  bodies.show(known(wall, husky));
  const [mesh] = bodies.of("room");
  bodies.show(known(wall));
  expect([...bodies.all()]).toEqual([mesh]);
  bodies.show(known({ ...wall }));
  expect([...bodies.all()][0]).not.toBe(mesh);
});

it("endless ground does not count for the size of a room", () => {
  const bodies = new Bodies();
  const ground = box("ground/link/plane", "world", 0);
  const endless: Entity = {
    ...ground,
    shapes: ground.shapes.map((shape) => ({ ...shape, size: [100, 100, 0.002] as const })),
  };
  bodies.show(known(endless, box("room/wall/a", "world", 3)));
  expect(bodies.room().getSize(new Vector3()).x).toBeCloseTo(2);
});

it("what moves is hidden until it is known where it is, what stays is not", () => {
  const bodies = new Bodies();
  bodies.show(known(box("room/wall/a", "world", 0), box("husky/base/deck", "husky/base", 0)));
  const shown = () =>
    [...bodies.all()].filter((mesh) => mesh.parent?.visible).map((mesh) => mesh.entity.body);
  bodies.move(() => IDENTITY, true);
  expect(shown()).toEqual(["room"]);
  bodies.move(() => IDENTITY);
  expect(shown()).toEqual(["room", "husky"]);
});
