import { expect, it } from "vitest";
import { inShell, meanOf, shown } from "./words";

it("a cell is short, and a missing one is a dash", () => {
  expect([0.1 + 0.2, 4, 2e-6, "event", true, null].map(shown)).toEqual([
    "0.3",
    "4",
    "2e-6",
    "event",
    "yes",
    "–",
  ]);
});

it("a mean has its spread if there is one", () => {
  const measured = { a: { mean: 1.23456, sd: 0.0456, n: 3 }, b: { mean: 2, sd: 0, n: 1 } };
  const group = { values: {}, runs: 3, passed: 0, measured };
  expect(["a", "b", "c"].map((name) => meanOf(group, name))).toEqual(["1.235 ± 0.046", "2", "–"]);
});

it("a word with spaces, brackets or quotes reaches a command as one", () => {
  expect(inShell(["nrp", "-s", "a=1 s", "b=[1, 2]", "it's"])).toBe("nrp -s 'a=1 s' 'b=[1, 2]' 'it'\\''s'");
});
