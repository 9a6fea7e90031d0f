import { expect, test } from "vitest";
import { TimeRing } from "../../plots/timeRing";
import { Fired, NEVER_S } from "./fired";
import { ballAround, inUnitBall, placesIn, spread } from "./places";

test("cells remember their last spike, also when time goes back", () => {
  const ring = new TimeRing(1024);
  ring.push(0.1, 2);
  const fired = new Fired(ring, 3);
  expect(fired.update()).toBe(true);
  expect(fired.update()).toBe(false);
  ring.push(0.2, 0);
  ring.push(0.3, 2);
  fired.update();
  expect([...fired.times_s].map((t_s) => Number(t_s.toFixed(3)))).toEqual([0.2, NEVER_S, 0.3]);
  ring.forgetFrom(0.15);
  expect(fired.update()).toBe(true);
  expect([...fired.times_s].map((t_s) => Number(t_s.toFixed(3)))).toEqual([NEVER_S, NEVER_S, 0.1]);
});

test("places come as bytes and fill a ball of radius 1", () => {
  const bytes = new Uint8Array(Float32Array.of(0, 0, 0, 300, 400, 0).buffer);
  const places = placesIn(btoa(String.fromCharCode(...bytes)));
  expect([...places]).toEqual([0, 0, 0, 300, 400, 0]);
  const ball = ballAround([places]);
  expect(ball).toEqual({ middle: [150, 200, 0], radius: 250 });
  expect([...inUnitBall(places, ball)].map((one) => Number(one.toFixed(3)))).toEqual([
    -0.6, -0.8, 0, 0.6, 0.8, 0,
  ]);
  expect(ballAround([Float32Array.of(5, 5, 5)]).radius).toBe(1);
});

test.each([0, 1, 2, 10, 997, 1000])(
  "of %i cells all are drawn, and the first of them are spread",
  (count) => {
    const order = [...spread(count)];
    expect(order.toSorted((a, b) => a - b)).toEqual([...Array(count).keys()]);
    const quarters = order.slice(0, count / 4).map((cell) => Math.floor((4 * cell) / count));
    if (count > 100)
      for (const one of [0, 1, 2, 3])
        expect(quarters.filter((each) => each === one).length).toBeGreaterThan(count / 20);
  },
);
