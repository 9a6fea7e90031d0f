import { Box3, Vector3 } from "three";
import { expect, it } from "vitest";
import { gridStep, Surroundings } from "./surroundings";

it("the grid has steps of a metre in rooms, and of a power of ten below smaller things", () => {
  expect([200, 8, 1, 0.9, 0.04, 0.0025, 0].map(gridStep)).toEqual([1, 1, 1, 0.1, 0.01, 0.001, 1]);
});

it("the ground under an insect lies below its table by less than the insect is high", () => {
  const surroundings = new Surroundings(false);
  surroundings.surround(new Box3(new Vector3(-0.02, -0.01, 0), new Vector3(0.02, 0.01, 0.002)));
  const grid = surroundings.root.children.find(({ type }) => type === "GridHelper");
  expect(grid?.position.z).toBeGreaterThan(-0.001);
  surroundings.dispose();
});
