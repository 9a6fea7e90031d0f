// @vitest-environment happy-dom
import { cleanup, render, screen } from "@testing-library/react";
import { afterEach, expect, test, vi } from "vitest";
import { toggleRecording } from "../state/commands";
import { useNotices } from "../state/notices";
import { useRun } from "../state/run";
import type { Experiment, Status } from "../state/types";
import { wire } from "../wire";
import { ShareButton } from "./ShareButton";

const show = (source: Experiment["source"], status: Partial<Status>) => {
  useRun.setState({
    link: { state: "open" },
    experiment: { source, may_steer: true } as Experiment,
    status: { state: "paused", recorded: null, recording: null, ...status } as Status,
  });
  render(<ShareButton />);
  return screen.queryByRole("button", { name: /Save as one HTML file/ });
};

afterEach(() => {
  cleanup();
  vi.restoreAllMocks();
  useRun.setState({ experiment: null, status: null, link: { state: "connecting" } });
  useNotices.setState({ notices: [] });
});

test("before a run is recorded the button says what is missing, and a shared file has none", () => {
  expect(show("live", {})?.getAttribute("aria-disabled")).toBe("true");
  cleanup();
  expect(show("live", { recorded: "/a/visit" })?.getAttribute("aria-disabled")).toBeNull();
  cleanup();
  expect(show("recording", {})).toBeNull();
});

test("the end of a recording says where it is", async () => {
  vi.spyOn(wire, "call").mockResolvedValue({});
  show("live", { recording: { path: "/a/visit", bytes: 1 } });
  await toggleRecording();
  expect(useNotices.getState().notices[0]?.text).toContain("/a/visit");
});

test("an error stays until it is closed", async () => {
  vi.useFakeTimers();
  vi.spyOn(wire, "call").mockRejectedValue(new Error("there is no topic"));
  await toggleRecording();
  vi.advanceTimersByTime(60_000);
  expect(useNotices.getState().notices).toHaveLength(1);
  vi.useRealTimers();
});
