import { expect, test } from "vitest";
import { binFor, histogramOf } from "./rates";
import { TimeRing } from "./timeRing";

test("the rate is that of one neuron, in bins that do not move with the window", () => {
  const spikes = new TimeRing(1024);
  for (let at = 0; at < 100; at++) spikes.push(0.005 + at * 0.01, at % 2);
  const { first, rates_hz } = histogramOf(spikes, 2, 0.23, 0.57, 0.1);
  expect(first).toBe(2);
  expect([...rates_hz].map(Math.round)).toEqual([50, 50, 50, 50]);
});

test("bins are round and about a hundred", () => {
  expect([4, 0.1, 60].map(binFor)).toEqual([0.05, 0.001, 0.5]);
});
