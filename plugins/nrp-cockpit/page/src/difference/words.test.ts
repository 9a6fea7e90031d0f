import { describe, expect, it } from "vitest";
import type { Comparison } from "./comparison";
import { differs, distanceOf, passedOf, timeOf, verdictOf } from "./words";

const same: Comparison = {
  labels: ["The run", "Branch of 0.60 s"],
  since_s: 0.6,
  distance_m: 0,
  distances: [[0.6, 0]],
  first: [],
  events: [],
  criteria: [],
  spikes: [],
};

describe("the verdict", () => {
  it("says that two runs are the same, and since when", () => {
    expect(verdictOf(same)).toBe("Identical since 0.60 s, to the last bit of each position and spike count.");
  });

  it("names the first difference and the distance now", () => {
    const first: Comparison["first"] = [
      { what: "spikes", t_s: 0.7 },
      { what: "trajectory", t_s: 0.74 },
    ];
    expect(verdictOf({ ...same, first, distance_m: 0.0123 })).toBe(
      "The number of spikes differs first, at 0.70 s. The robots are 12.3 mm apart.",
    );
  });
});

describe("words", () => {
  it("keep a distance readable from nanometres to metres", () => {
    expect([0, 2e-9, 4.5e-5, 0.25, 12.345].map(distanceOf)).toEqual([
      "0 m",
      "2.0 nm",
      "45.0 µm",
      "250 mm",
      "12.35 m",
    ]);
  });

  it("tell what has not happened and what is not decided", () => {
    expect([timeOf(null), timeOf(3.456)]).toEqual(["not yet", "3.46 s"]);
    expect([null, true, false].map(passedOf)).toEqual(["undecided", "passed", "failed"]);
  });

  it("mark a row whose two values are not the same", () => {
    expect([differs({ name: "a", one: 1, other: 1 }), differs({ name: "a", one: 1, other: null })]).toEqual([
      false,
      true,
    ]);
  });
});
