import { expect, it } from "vitest";
import { writeTouches } from "./touches";

const up = { x: 0, y: 0, z: 1 };
const state = (...points: [number, number, number][]) => ({
  contact_positions: points.map(([x, y, z]) => ({ x, y, z })),
  contact_normals: points.map(() => up),
});

it("each contact of each pair is a point and the end of its normal", () => {
  const lines = new Float32Array(18);
  expect(writeTouches({ states: [state([1, 2, 3]), state([4, 5, 6], [7, 8, 9])] }, lines)).toBe(3);
  const near = [...lines].map((value) => Number(value.toFixed(3)));
  expect(near).toEqual([1, 2, 3, 1, 2, 3.15, 4, 5, 6, 4, 5, 6.15, 7, 8, 9, 7, 8, 9.15]);
});

it("contacts beyond the room in memory are left out", () => {
  expect(writeTouches({ states: [state([1, 2, 3], [4, 5, 6])] }, new Float32Array(6))).toBe(1);
});
