// @vitest-environment happy-dom
import { act, cleanup, render } from "@testing-library/react";
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { useRun } from "../state/run";
import type { Experiment } from "../state/types";
import { PAST, wire } from "../wire";
import { CameraPanel } from "./CameraPanel";

const TOPIC = "/husky/camera";
const handlers = new Map<string, (message: unknown, t_s: number) => void>();
/** Ends the decoding of an image. */
const decoded: ((bitmap: object) => void)[] = [];
const painted: unknown[] = [];

beforeEach(() => {
  decoded.length = painted.length = 0;
  const topics = [{ name: TOPIC, type: "sensor_msgs/CompressedImage", rate_hz: 20 }];
  useRun.setState({ experiment: { topics, source: "live" } as unknown as Experiment });
  vi.spyOn(wire, "subscribe").mockImplementation((topic, handler) => {
    handlers.set(topic, handler as (message: unknown, t_s: number) => void);
    return () => undefined;
  });
  vi.stubGlobal("createImageBitmap", () => new Promise((resolve) => decoded.push(resolve)));
  vi.spyOn(HTMLCanvasElement.prototype, "getContext").mockReturnValue({
    drawImage: ({ name }: { name: string }) => painted.push(name),
  } as unknown as CanvasRenderingContext2D);
});
afterEach(() => {
  cleanup();
  vi.restoreAllMocks();
  vi.unstubAllGlobals();
  useRun.setState({ experiment: null });
});

const hear = () => act(async () => handlers.get(TOPIC)?.({ format: "jpeg", data: new Uint8Array() }, 1));
const decode = (at: number, name: string) =>
  act(async () => decoded[at]?.({ name, width: 4, height: 4, close: () => undefined }));

test("an image that is decoded after the run went back is not painted over the one of then", async () => {
  render(<CameraPanel />);
  await hear();
  await act(async () => handlers.get(PAST)?.({ topic: TOPIC, from_s: 0, count: 1, new: false }, 0));
  await hear();
  await decode(1, "of then");
  await decode(0, "of the future");
  expect(painted).toEqual(["of then"]);
});

test("an image that is decoded after a later one is not painted over it", async () => {
  render(<CameraPanel />);
  await hear();
  await hear();
  await decode(1, "second");
  await decode(0, "first");
  await hear();
  await decode(2, "third");
  expect(painted).toEqual(["second", "third"]);
});
