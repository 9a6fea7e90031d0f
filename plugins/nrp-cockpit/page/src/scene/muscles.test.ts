import { type Mesh, type MeshLambertMaterial, Vector3 } from "three";
import { expect, it } from "vitest";
import { Muscles } from "./muscles";

const muscle = (z: number, r: number) => ({
  points: [
    { x: 0, y: 0, z: 0 },
    { x: 3, y: 0, z },
    { x: 3, y: 1, z },
  ],
  thickness: 0.2,
  color: { r, g: 0, b: 1 - r, a: 1 },
});

it("a muscle is a tube from point to point, which moves and changes its colour", () => {
  const muscles = new Muscles();
  muscles.show([muscle(0, 0)]);
  const pieces = [...muscles.root.children] as Mesh[];
  expect(pieces).toHaveLength(5);
  muscles.show([muscle(4, 1)]);
  expect([...muscles.root.children]).toEqual(pieces);
  const line = pieces.find(({ scale }) => scale.z > 1) as Mesh;
  line.updateMatrixWorld();
  const at = (end: number) => new Vector3(0, 0, end).applyMatrix4(line.matrixWorld);
  expect(at(-0.5).distanceTo(new Vector3(0, 0, 0))).toBeCloseTo(0);
  expect(at(0.5).distanceTo(new Vector3(3, 0, 4))).toBeCloseTo(0);
  expect((line.material as MeshLambertMaterial).color.toArray()).toEqual([1, 0, 0]);
  muscles.show([]);
  expect(muscles.root.children).toHaveLength(0);
});
