import { expect, test, vi } from "vitest";
import { SimClock } from "./simClock";

test("data move the time on, but never back", () => {
  const clock = new SimClock();
  clock.run(1);
  clock.data(1.5);
  clock.data(1.2);
  expect(clock.now_s).toBe(1.5);
});

test("a status that is behind the data forgets nothing", () => {
  const clock = new SimClock();
  const forget = vi.fn();
  clock.onBack(forget);
  clock.run(1);
  clock.data(1.5);
  clock.run(1.4);
  expect(forget).not.toHaveBeenCalled();
});

test("a run that goes back forgets what was later", () => {
  const clock = new SimClock();
  const forget = vi.fn();
  clock.onBack(forget);
  clock.run(9);
  clock.run(2);
  expect(forget).toHaveBeenCalledExactlyOnceWith(2);
  expect(clock.now_s).toBe(2);
});
