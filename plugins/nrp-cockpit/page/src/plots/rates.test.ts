import { expect, test } from "vitest";
import { binFor, RateTable } from "./rates";
import { TimeRing } from "./timeRing";

test("the rate is that of one neuron, in bins that do not move with the window", () => {
  const spikes = new TimeRing(1024);
  const lineOf = Int32Array.of(0, 0, 1, -1);
  for (let at = 0; at < 100; at++) spikes.push(0.005 + at * 0.01, at % 2);
  spikes.push(1.05, 2);
  spikes.push(1.06, 3);
  const table = new RateTable(0.34, 0.1, [2, 1]);
  const rates = (line: number) =>
    Array.from({ length: table.bins }, (_, bin) => Math.round(table.rate_hz(line, table.first + bin)));
  table.count(0.23, [{ ring: spikes, lineOf }]);
  expect(table.first).toBe(2);
  expect(rates(0)).toEqual([50, 50, 50, 50, 50]);
  table.count(0.75, [{ ring: spikes, lineOf }]);
  expect(rates(0)).toEqual([50, 50, 50, 0, 0]);
  expect(rates(1)).toEqual([0, 0, 0, 10, 0]);
  expect(table.highest_hz(1)).toBeCloseTo(10);
});

test("bins are round and about a hundred", () => {
  expect([4, 0.1, 60].map(binFor)).toEqual([0.05, 0.001, 0.5]);
});
