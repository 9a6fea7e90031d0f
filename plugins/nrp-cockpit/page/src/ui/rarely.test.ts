import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { Rarely } from "./rarely";

beforeEach(() => {
  vi.useFakeTimers({ toFake: ["setTimeout", "clearTimeout", "performance"] });
});
afterEach(() => {
  vi.useRealTimers();
});

/** How often a call is made that is asked for at these times, and when. */
function callsAt(asked_ms: readonly number[], until_ms: number): number[] {
  const made: number[] = [];
  const began_ms = performance.now();
  const rarely = new Rarely(() => made.push(performance.now() - began_ms), 100);
  for (const at_ms of asked_ms) {
    vi.advanceTimersByTime(began_ms + at_ms - performance.now());
    rarely.ask();
  }
  vi.advanceTimersByTime(began_ms + until_ms - performance.now());
  return made;
}

test("the first call is made at once, and the last that was asked for is made", () => {
  expect(callsAt([0], 500)).toEqual([0]);
  expect(callsAt([0, 20, 40, 60], 500)).toEqual([0, 100]);
  expect(callsAt([0, 250], 500)).toEqual([0, 250]);
});

test("fifty requests a second are ten calls", () => {
  const asked_ms = Array.from({ length: 50 }, (_, at) => 20 * at);
  expect(callsAt(asked_ms, 2000)).toEqual([0, 100, 200, 300, 400, 500, 600, 700, 800, 900, 1000]);
});

test("what was asked for is not done once it is stopped", () => {
  const call = vi.fn();
  const rarely = new Rarely(call, 100);
  rarely.ask();
  rarely.ask();
  rarely.stop();
  vi.advanceTimersByTime(500);
  expect(call).toHaveBeenCalledTimes(1);
});
