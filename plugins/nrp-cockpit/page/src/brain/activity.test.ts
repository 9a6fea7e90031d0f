import { describe, expect, test } from "vitest";
import { Spans } from "../plots/spans";
import { TimeRing } from "../plots/timeRing";
import { boxBrightness, boxRates, brightnessOf, ratesNow } from "./activity";

const spikes = (...times_s: number[]) => {
  const ring = new TimeRing(1024);
  for (const t_s of times_s) ring.push(t_s, 1);
  return ring;
};
const brightness = (now_s: number, ...times_s: number[]) =>
  brightnessOf(spikes(...times_s), 2, now_s)[1] ?? 0;

describe("brightness", () => {
  test("decays with simulated time after a spike", () => {
    expect(brightness(1, 1)).toBeGreaterThan(brightness(1.1, 1));
    expect(brightness(1.1, 1)).toBeGreaterThan(brightness(1.4, 1));
    expect(brightness(9, 1)).toBe(0);
  });

  test("rises with the rate, and stays below 1", () => {
    const train = (rate_hz: number) => Array.from({ length: rate_hz }, (_, at) => (at + 1) / rate_hz);
    const [slow, fast] = [brightness(1, ...train(10)), brightness(1, ...train(300))];
    expect(slow).toBeLessThan(0.5);
    expect(fast).toBeGreaterThan(0.95);
    expect(fast).toBeLessThanOrEqual(1);
  });

  test("belongs to the neuron that fired", () => {
    expect(brightnessOf(spikes(1), 2, 1)[0]).toBe(0);
  });
});

const heardFrom = (from_s: number) => {
  const heard = new Spans();
  heard.begin(from_s);
  return heard;
};

test("rates count the last second, and at the begin of a run what there was", () => {
  expect(ratesNow(spikes(0.5, 1.5, 1.8, 2), heardFrom(0), 2, 2)?.[1]).toBe(3);
  expect(ratesNow(spikes(0.1, 0.2), heardFrom(0), 2, 0.2)?.[1]).toBe(10);
});

test("rates relate to the time that was heard, and are unknown where that is too short", () => {
  expect(ratesNow(spikes(1.6, 1.8, 2), heardFrom(1.5), 2, 2)?.[1]).toBe(6);
  expect(ratesNow(spikes(2), heardFrom(1.9), 2, 2)).toBeNull();
  expect(ratesNow(spikes(), heardFrom(0), 2, 0.02)?.[1]).toBe(0);
  expect(ratesNow(spikes(), heardFrom(0), 2, 0)).toBeNull();
  expect(ratesNow(spikes(), new Spans(), 2, 0)).toBeNull();
});

test("boxes shine and fire as their cells do on average", () => {
  const ring = spikes(1.5, 1.8, 2);
  const grouping = { names: ["a", null], sizes: [1, 3], partOf: Uint16Array.of(1, 0, 1, 1) };
  expect([...(boxRates(ring, heardFrom(0), grouping, 2) ?? [])]).toEqual([3, 0]);
  const [a, rest] = boxBrightness(ring, grouping, 2);
  expect(a).toBeCloseTo(brightnessOf(ring, 4, 2)[1] ?? 0);
  expect(rest).toBe(0);
  const whole = boxBrightness(ring, { names: [null], sizes: [4], partOf: new Uint16Array(4) }, 2);
  expect(whole[0]).toBeCloseTo((a ?? 0) / 4);
});
