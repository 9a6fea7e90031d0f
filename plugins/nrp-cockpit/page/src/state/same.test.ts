import { expect, test } from "vitest";
import { keepSame } from "./same";

test("what did not change stays the same object", () => {
  const before = { groups: [{ name: "left" }], devices: [1], seed: 1 };
  const next = keepSame(before, { groups: [{ name: "left" }], devices: [1, 2], seed: 2 });
  expect(next.groups).toBe(before.groups);
  expect(next).toEqual({ groups: [{ name: "left" }], devices: [1, 2], seed: 2 });
  expect(keepSame(null, before)).toBe(before);
});
