// @vitest-environment happy-dom
import { act, cleanup, fireEvent, render, screen } from "@testing-library/react";
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { useRun } from "../state/run";
import type { Experiment, Status } from "../state/types";
import { wire } from "../wire";
import { IDENTITY } from "../world/pose";
import { world } from "../world/world";
import { EditBar } from "./EditBar";
import { addAt, nudge, put, shifted, shiftOf, useEditing } from "./editing";

const experiment = {
  file: "hall.yaml",
  may_steer: true,
  capabilities: {},
  bodies: [{ name: "pillar", static: true, pose: { position: [1, 0, 0.5], orientation: [0, 0, 0, 1] } }],
} as unknown as Experiment;
const calls: [string, unknown][] = [];
let free: () => void = () => undefined;
let waits = false;

beforeEach(() => {
  useRun.setState({ link: { state: "open" }, experiment, status: { state: "paused" } as Status });
  useEditing.setState({ isOn: true, adding: null, moved: null, said: "", steps: [] });
  calls.length = 0;
  waits = false;
  vi.spyOn(wire, "call").mockImplementation(async (name, request) => {
    calls.push([name.replace("/cockpit/", ""), request]);
    if (waits)
      await new Promise<void>((resolve) => {
        free = resolve;
      });
    return name.endsWith("models") ? { models: ["box", "palm"] } : { body: "box_2", number: 7 };
  });
});
afterEach(() => {
  cleanup();
  world.models.clear();
  vi.restoreAllMocks();
});

test("what the server offers can be added, and Undo removes it", async () => {
  const focus = vi.fn();
  render(<EditBar canvas={{ current: { focus } as unknown as HTMLCanvasElement }} />);
  await act(async () => undefined);
  fireEvent.click(screen.getByRole("button", { name: "Add a body" }));
  fireEvent.click(screen.getByRole("menuitem", { name: "palm" }));
  expect(focus).toHaveBeenCalled();
  expect(screen.getByRole("status").textContent).toContain("Click where the palm stands");
  await act(async () => addAt("palm", [1, 2, 0]));
  expect(useEditing.getState().adding).toBeNull();
  fireEvent.click(screen.getByRole("button", { name: "Remove box_2" }));
  await act(async () => undefined);
  expect(calls.slice(1)).toEqual([
    ["bodies/add", { model: "palm", position: [1, 2, 0], size_m: 0.4 }],
    ["bodies/remove", { body: "box_2" }],
  ]);
  expect(screen.getByRole("button", { name: "Undo" }).getAttribute("aria-disabled")).toBe("true");
});

test("Undo puts a body back where it was", async () => {
  world.models.set("husky", { position: [3, 4, 0.1], orientation: [0, 0, 1, 0] });
  render(<EditBar canvas={{ current: null }} />);
  await act(async () => put("husky", { ...IDENTITY, position: [5, 5, 0.1] }));
  fireEvent.click(screen.getByRole("button", { name: "Put husky back" }));
  await act(async () => undefined);
  expect(calls.at(-1)).toEqual([
    "place",
    { body: "husky", position: [3, 4, 0.1], orientation: [0, 0, 1, 0], undoes: 7 },
  ]);
});

test("keys add up while the server is busy, and the last place is the one that counts", async () => {
  waits = true;
  for (let key = 0; key < 3; key++) nudge("pillar", { x: 0.1, y: 0, yaw: 0 });
  expect(useEditing.getState().said).toBe("pillar: x 1.30 m, y 0.00 m, 0°");
  waits = false;
  await act(async () => free());
  await vi.waitFor(() => expect(useEditing.getState().moved).toBeNull());
  const places = calls.map(([, request]) => (request as { position: number[] }).position[0]);
  expect(places.map((x) => x?.toFixed(2))).toEqual(["1.10", "1.30"]);
});

test.each([
  ["ArrowUp", -Math.PI / 2, [0, 1]], // seen from the south: up is north
  ["ArrowRight", -Math.PI / 2, [1, 0]],
  ["ArrowUp", 0.2, [-1, 0]], // seen from the east
  ["ArrowRight", 0.2, [0, 1]],
  ["ArrowDown", 3, [-1, 0]], // seen from the west
])("%s moves a body as it is seen from %f rad", (key, azimuth, [x, y]) => {
  const shift = shiftOf(key, false, azimuth);
  expect([Math.round(10 * (shift?.x ?? 0)) + 0, Math.round(10 * (shift?.y ?? 0)) + 0]).toEqual([x, y]);
});

test("a body turns about its own origin", () => {
  const turn = shiftOf("ArrowLeft", true, 0);
  const { position, orientation } = shifted(
    { ...IDENTITY, position: [1, 2, 3] },
    turn ?? { x: 9, y: 9, yaw: 9 },
  );
  expect(position).toEqual([1, 2, 3]);
  expect(2 * Math.asin(orientation[2])).toBeCloseTo(Math.PI / 36);
  expect(shiftOf("ArrowUp", true, 0)).toBeNull();
  expect(shiftOf("x", false, 0)).toBeNull();
});
