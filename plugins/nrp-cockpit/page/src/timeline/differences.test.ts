import { expect, test } from "vitest";
import type { Comparison } from "../difference/comparison";
import { differencesOf, stretchesOf, stretchWords } from "./differences";

const comparison: Comparison = {
  labels: ["The run", "Branch of 1.00 s"],
  since_s: 1,
  distance_m: 2,
  distances: [
    [1, 0],
    [2, 0],
    [4, 1],
    [7, 2],
  ],
  first: [
    { what: "trajectory", t_s: 4 },
    { what: "spikes", t_s: 4.5 },
  ],
  events: [
    { name: "left_red", one: 2, other: 2 },
    { name: "reached", one: 6, other: null },
    { name: "late", one: null, other: 4.2 },
    { name: "never", one: null, other: null },
  ],
  criteria: [],
  spikes: [],
};

test("the time since the branch is covered without a gap, the same where the robots are", () => {
  const stretches = stretchesOf(comparison);
  expect(stretches[0]).toMatchObject({ from_s: 1, share: 0, most_m: 0 });
  expect(stretches.at(-1)?.to_s).toBeCloseTo(7);
  for (const [at, { from_s }] of stretches.entries()) {
    const before = stretches[at - 1];
    if (before) expect(from_s).toBeCloseTo(before.to_s);
  }
  expect(Math.max(...stretches.map(({ share }) => share))).toBe(1);
  expect(stretches.find(({ share }) => share === 0.5)).toMatchObject({ most_m: 1 });
});

test("a branch that has not gone on has nothing to show", () => {
  expect(stretchesOf({ ...comparison, distances: [[1, 0]] })).toEqual([]);
});

test("what differs is listed in the order of time, what is alike is not", () => {
  expect(differencesOf(comparison).map(({ name, t_s }) => [name, t_s])).toEqual([
    ["path", 4],
    ["late", 4.2],
    ["spikes", 4.5],
    ["reached", 6],
  ]);
  expect(differencesOf(comparison)[1]?.words).toBe("Event late: The run not yet, Branch of 1.00 s 4.20 s");
});

test("a stretch says in words how far the robots are apart", () => {
  expect(stretchWords({ from_s: 1, to_s: 2, share: 0, most_m: 0 })).toBe("1.00 to 2.00 s: the same");
  expect(stretchWords({ from_s: 1, to_s: 2, share: 1, most_m: 0.25 })).toBe(
    "1.00 to 2.00 s: at most 250 mm apart",
  );
});
