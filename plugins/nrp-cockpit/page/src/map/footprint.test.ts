import { describe, expect, it } from "vitest";
import type { Entity, Kind, Shape } from "../world/entities";
import { fromRollPitchYaw, IDENTITY, type Pose } from "../world/pose";
import { contains, convexHull, extentOf, footprintsOf } from "./footprint";
import { bodyAt } from "./plan";
import { boxOfStl } from "./stl";

const shape = (kind: Kind, size: [number, number, number], pose: Pose = IDENTITY): Shape => ({
  kind,
  size,
  pose,
  color: { r: 1, g: 0, b: 0, a: 1 },
  mesh: null,
});

const entity = (...shapes: Shape[]): Entity => ({ id: "a/b/c", body: "a", frame: "a/b", shapes });

const area = (outline: readonly (readonly [number, number])[]) =>
  outline.reduce((sum, [x, y], at) => {
    const [nx, ny] = outline[(at + 1) % outline.length] ?? [0, 0];
    return sum + (x * ny - nx * y) / 2;
  }, 0);

function stl(...triangles: number[][]): Uint8Array {
  const view = new DataView(new ArrayBuffer(84 + 50 * triangles.length));
  view.setUint32(80, triangles.length, true);
  triangles.forEach((corners, triangle) => {
    corners.forEach((value, at) => {
      view.setFloat32(84 + 50 * triangle + 12 + 4 * at, value, true);
    });
  });
  return new Uint8Array(view.buffer);
}

describe("what a shape covers from above", () => {
  it("is a rectangle for a box, in the place and the direction of its frame", () => {
    const frame: Pose = { position: [10, 0, 1], orientation: fromRollPitchYaw(0, 0, Math.PI / 2) };
    const [one] = footprintsOf(entity(shape("cube", [4, 2, 1])), frame);
    expect(one).toMatchObject({ body: "a", bottom_m: 0.5, top_m: 1.5 });
    expect(area(one?.outline ?? [])).toBeCloseTo(8);
    expect(contains(one?.outline ?? [], [10.9, 1.9])).toBe(true);
    expect(contains(one?.outline ?? [], [11.9, 0.9])).toBe(false);
  });

  it("is narrow for a screen that stands, and wide for one that lies", () => {
    const screen = entity(shape("cube", [2, 1, 0.1]));
    const standing = { ...IDENTITY, orientation: fromRollPitchYaw(Math.PI / 2, 0, 0) };
    expect(area(footprintsOf(screen, standing)[0]?.outline ?? [])).toBeCloseTo(0.2);
    expect(area(footprintsOf(screen, IDENTITY)[0]?.outline ?? [])).toBeCloseTo(2);
  });

  it("is nearly a circle for a ball and for an upright cylinder", () => {
    const round = entity(shape("sphere", [2, 2, 2]), shape("cylinder", [2, 2, 5]));
    for (const { outline } of footprintsOf(round, IDENTITY)) {
      expect(area(outline)).toBeGreaterThan(0.95 * Math.PI);
      expect(area(outline)).toBeLessThan(Math.PI);
    }
  });

  it("is the box of the triangles for a mesh, with its factors", () => {
    const data = stl([0, 0, 0, 1, 0, 0, 0, 2, 3]);
    expect(boxOfStl(data)).toEqual({ min: [0, 0, 0], max: [1, 2, 3] });
    const mesh: Shape = { ...shape("mesh", [2, 1, 1]), mesh: { data, type: "model/stl" } };
    const [one] = footprintsOf(entity(mesh), IDENTITY);
    expect(area(one?.outline ?? [])).toBeCloseTo(4);
  });

  it("is nothing for a file that is not STL", () => {
    expect(boxOfStl(new Uint8Array(84).fill(7))).toBeNull();
    const mesh: Shape = { ...shape("mesh", [1, 1, 1]), mesh: { data: new Uint8Array(3), type: "x" } };
    expect(footprintsOf(entity(mesh), IDENTITY)).toEqual([]);
  });
});

it("the extent of a body is that of all its shapes", () => {
  const parts = [
    entity(shape("cube", [2, 2, 1])),
    entity(shape("cube", [1, 1, 1], { ...IDENTITY, position: [3, 0, 2] })),
  ];
  expect(extentOf(parts, () => IDENTITY)).toEqual({ x: [-1, 3.5], y: [-1, 1], z: [-0.5, 2.5] });
  expect(extentOf([], () => IDENTITY)).toBeNull();
});

it("a hull leaves out the points inside and on its sides", () => {
  const hull = convexHull([
    [0, 0],
    [1, 0],
    [2, 0],
    [2, 2],
    [0, 2],
    [1, 1],
  ]);
  expect(hull).toHaveLength(4);
  expect(area(hull)).toBe(4);
});

it("a click hits what is on top", () => {
  const floor = footprintsOf({ ...entity(shape("cube", [9, 9, 0.1])), body: "floor" }, IDENTITY);
  const table = footprintsOf({ ...entity(shape("cube", [1, 1, 1])), body: "table" }, IDENTITY);
  expect(bodyAt([...table, ...floor], [0, 0])).toBe("table");
  expect(bodyAt([...table, ...floor], [3, 0])).toBe("floor");
  expect(bodyAt([...table, ...floor], [30, 0])).toBeNull();
});
