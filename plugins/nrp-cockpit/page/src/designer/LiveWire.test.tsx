// @vitest-environment happy-dom
import { act, cleanup, render, screen } from "@testing-library/react";
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { useRun } from "../state/run";
import type { Experiment, Status } from "../state/types";
import { wire } from "../wire";
import { useValue } from "./LiveWire";
import type { Box, WireData } from "./types";
import { type Carried, carriedBy, fitted, textOf } from "./wireValue";

const device = (name: string, unit = "Hz") => ({ name, topic: `/brain/devices/${name}/rate`, unit });
const experiment = {
  topics: [
    { name: "/cmd_vel", type: "geometry_msgs/Twist", unit: null, rate_hz: null },
    { name: "/camera", type: "sensor_msgs/Image", unit: null, rate_hz: 10 },
  ],
  devices: [device("eyes/left"), ...[0, 1, 2, 3, 4].map((place) => device(`eyes/all/${place}`))],
} as unknown as Experiment;
const handlers = new Map<string, (message: unknown, t_s: number) => void>();
const status = (t_s: number) => useRun.setState({ status: { t_s } as Status });

beforeEach(() => {
  vi.useFakeTimers();
  handlers.clear();
  useRun.setState({ experiment });
  status(1);
  vi.spyOn(wire, "subscribe").mockImplementation((topic, handler) => {
    handlers.set(topic, handler as (message: unknown, t_s: number) => void);
    return () => handlers.delete(topic);
  });
});
afterEach(() => {
  cleanup();
  vi.useRealTimers();
  vi.restoreAllMocks();
});

function Value({ of }: { of: Carried | null }) {
  return <output>{useValue(of)}</output>;
}
const text = () => screen.getByRole("status").textContent;
const hear = (topic: string, message: unknown, t_s = 1) =>
  act(() => {
    handlers.get(topic)?.(message, t_s);
    vi.advanceTimersByTime(300);
  });

test("a wire shows the latest value of its device with its unit, and nothing before it is known", () => {
  const of = { device: "eyes/left" };
  const { unmount } = render(<Value of={of} />);
  expect(text()).toBe("–");
  hear("/brain/devices/eyes/left/rate", {
    layout: { dim: [], data_offset: 3 },
    data: new Float64Array([98.25]),
  });
  expect(text()).toBe("98.3 Hz");
  unmount();
  expect(handlers.size).toBe(0);
});

test("of a velocity what moves is shown, and speed and turn in any case", () => {
  const twist = { linear: { x: 0.5, y: 0, z: 0 }, angular: { x: 0, y: 0, z: -3.128 } };
  expect(textOf([{ header: { stamp: 7 }, twist }], "")).toBe("vx 0.500\nωz -3.13");
  expect(textOf([{ ...twist, linear: { x: 0, y: 0, z: 2 } }], "")).toBe("vx 0\nvz 2.00\nωz -3.13");
  const odometry = { pose: { position: { x: 1, y: 2, z: 3 } }, twist };
  expect(textOf([odometry], "")).toBe("1.00 2.00 3.00 …");
});

test("of a message and of a group of devices the first numbers are shown", () => {
  expect(textOf([{ header: { stamp: 7 }, data: [0.5, 0, 1e-40, 4] }], "")).toBe("0.500 0 ≈ 0 …");
  expect(textOf([{ data: "red" }], "")).toBe("red");
  render(<Value of={{ device: "eyes/all" }} />);
  expect(handlers.size).toBe(4);
  for (const place of [0, 1, 2, 3]) hear(`/brain/devices/eyes/all/${place}/rate`, { data: 10 * place });
  expect(text()).toBe("0 10.0 20.0 … Hz");
});

test("a wire shows whole numbers only, as many as have room between its boxes", () => {
  expect(fitted("0.0411 mV", 52)).toBe("0.0411 mV");
  expect(fitted("0.821 0 0 …", 52)).toBe("0.821 0 …");
  expect(fitted("vx 0.821\nωz -0.00123", 52)).toBe("vx 0.821\nωz …");
  expect(fitted("0.821 0 0 …", 20)).toBe("…");
});

test("images are not sent for a wire, which shows their rate", () => {
  render(<Value of={{ topic: "/camera" }} />);
  expect(text()).toBe("10 Hz");
  expect(handlers.size).toBe(0);
});

test("what is drawn and does not run has no value, and after a way back the later one is unknown", () => {
  render(<Value of={{ device: "new/one" }} />);
  expect(text()).toBe("–");
  cleanup();
  render(<Value of={{ topic: "/cmd_vel" }} />);
  hear("/cmd_vel", { data: 1 }, 1);
  expect(text()).toBe("1.00");
  act(() => status(0.5));
  act(() => vi.advanceTimersByTime(300));
  expect(text()).toBe("–");
  hear("/cmd_vel", { data: 2 }, 0.5);
  expect(text()).toBe("2.00");
});

test("a wire carries a topic or a device", () => {
  const path = "transfer_function/0/device/0";
  const boxes = [{ rows: [{ path, kind: "device", device: "drive/left", text: "" }] }] as unknown as Box[];
  const wireOf = (source_end: string, target_end: string) => ({ source_end, target_end }) as WireData;
  expect(carriedBy(wireOf("topic:/camera", path), boxes)).toEqual({ topic: "/camera" });
  expect(carriedBy(wireOf("population:actors[0]", path), boxes)).toEqual({ device: "drive/left" });
  expect(carriedBy(wireOf("population:actors[0]", "elsewhere"), boxes)).toBeNull();
});
