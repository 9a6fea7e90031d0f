import { expect, it } from "vitest";
import { newtons } from "./push";

it("a force has a unit in which it is not zero", () => {
  expect([0, 120, 1.2, 0.25, 4.5e-6].map(newtons)).toEqual(["0 N", "120 N", "1 N", "250 mN", "4.5 µN"]);
});
