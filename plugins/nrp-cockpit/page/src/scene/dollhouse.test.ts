import { expect, it } from "vitest";
import { parts } from "./dollhouse";

it("a wall between the eye and the target hides the room", () => {
  expect(parts(8, -5)).toBe(true);
  expect(parts(-8, 5)).toBe(true);
});

it("a wall behind the target, or the floor on which it lies, hides nothing", () => {
  expect(parts(8, 5)).toBe(false);
  expect(parts(8, -0.002)).toBe(false);
});
