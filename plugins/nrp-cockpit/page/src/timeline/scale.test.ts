import { expect, test } from "vitest";
import type { TimelineData } from "../state/types";
import { niceAbove, percent, showing, ticks, timeAt, wholeSpan, zoomed } from "./scale";

const nothing: TimelineData = {
  duration_s: null,
  events: [],
  interventions: [],
  criteria: [],
  failures: [],
  snapshots: [],
  automatic_s: [],
  edits: [],
};
const whole = { from_s: 0, to_s: 40 };

test("a run of known duration is shown whole", () => {
  expect(wholeSpan({ ...nothing, duration_s: 40 }, 3)).toEqual(whole);
});

test("a run that went on beyond its duration is shown to where it is", () => {
  expect(wholeSpan({ ...nothing, duration_s: 40 }, 41)).toEqual({ from_s: 0, to_s: 41 });
});

test("a run of open end is shown beyond the last thing that is known of it", () => {
  const events = [{ name: "later", t_s: 30, waits_for: "" }];
  expect(wholeSpan({ ...nothing, events }, 3)).toEqual({ from_s: 0, to_s: 50 });
});

test("a nice number is never below the one that was asked for", () => {
  expect([0.03, 1, 1.01, 3, 7, 20].map(niceAbove)).toEqual([0.05, 1, 2, 5, 10, 20]);
});

test("zooming keeps the time at the pointer in its place", () => {
  const near = zoomed(whole, whole, 0.5, 10);
  expect(near).toEqual({ from_s: 5, to_s: 25 });
  expect(percent(near, 10)).toBe(percent(whole, 10));
});

test("zooming out stops at the whole", () => {
  expect(zoomed({ from_s: 30, to_s: 40 }, whole, 8, 39)).toEqual(whole);
});

test("a zoomed view follows the run only when the run leaves it", () => {
  const span = { from_s: 10, to_s: 20 };
  expect(showing(span, whole, 15)).toEqual(span);
  expect(showing(span, whole, 21)).toEqual({ from_s: 18.5, to_s: 28.5 });
  expect(showing(span, whole, 0)).toEqual({ from_s: 0, to_s: 10 });
});

test("a share of the view and the time at it are each other's inverse", () => {
  expect(timeAt(whole, percent(whole, 12.34) / 100)).toBeCloseTo(12.34, 9);
});

test("the ruler has round times, no more than fit", () => {
  expect(ticks(whole, 10)).toEqual([0, 5, 10, 15, 20, 25, 30, 35, 40]);
  expect(ticks({ from_s: 0.31, to_s: 0.74 }, 5)).toEqual([0.4, 0.5, 0.6, 0.7]);
});
