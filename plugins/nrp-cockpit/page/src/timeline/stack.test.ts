import { expect, test } from "vitest";
import { stack } from "./stack";

test("stretches one after the other share a row", () => {
  expect(
    stack([
      { from_s: 0, to_s: 5 },
      { from_s: 5, to_s: 7 },
    ]),
  ).toEqual([0, 0]);
});

test("stretches that overlap stand in different rows", () => {
  expect(
    stack([
      { from_s: 5, to_s: 20 },
      { from_s: 0, to_s: 6 },
      { from_s: 7, to_s: 9 },
    ]),
  ).toEqual([1, 0, 0]);
});
