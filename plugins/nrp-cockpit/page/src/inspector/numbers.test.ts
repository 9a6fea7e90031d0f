import { expect, it } from "vitest";
import { degrees, fixed, parseNumbers, radians } from "./numbers";

it("numbers are read with a point or a comma", () => {
  const { values, ok } = parseNumbers({ x: " 1.5", y: "-2,25", yaw: "90" });
  expect(ok).toBe(true);
  expect(values).toEqual({ x: 1.5, y: -2.25, yaw: 90 });
});

it("each text that is not a number is named", () => {
  const { errors, ok } = parseNumbers({ x: "", y: "far", z: "1" });
  expect(ok).toBe(false);
  expect(Object.keys(errors)).toEqual(["x", "y"]);
});

it("a small negative number does not become minus zero", () => {
  expect([fixed(-0.001, 2), fixed(-0.01, 2), fixed(3, 1)]).toEqual(["0.00", "-0.01", "3.0"]);
});

it("degrees and radians undo each other", () => {
  expect(degrees(radians(37))).toBeCloseTo(37);
  expect(degrees(Math.PI)).toBe(180);
});
