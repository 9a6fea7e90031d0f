// @vitest-environment happy-dom
import { cleanup, fireEvent, render, screen } from "@testing-library/react";
import { afterEach, expect, test, vi } from "vitest";
import { useNotices } from "../state/notices";
import { useRun } from "../state/run";
import type { Experiment, Status } from "../state/types";
import { wire } from "../wire";
import { Track } from "./Track";

const SPAN = { from_s: 0, to_s: 40 };

/** Shows a run at 2 s on a track of 400 px, and clicks at a time. */
function click(state: Status["state"], t_s: number) {
  vi.stubGlobal(
    "ResizeObserver",
    class {
      observe() {}
      disconnect() {}
    },
  );
  useNotices.setState({ notices: [] }); // other tests may have left some
  useRun.setState({
    link: { state: "open" },
    experiment: { source: "live", may_steer: true, timestep_s: 0.02, capabilities: {} } as Experiment,
    status: { state, t_s: 2 } as Status,
  });
  render(
    <Track span={SPAN} end_s={40} onZoom={() => {}}>
      {null}
    </Track>,
  );
  const track = screen.getByRole("slider").parentElement as HTMLElement;
  track.getBoundingClientRect = () => new DOMRect(0, 0, 400, 100);
  const at = { clientX: 10 * t_s, button: 0, pointerId: 1, pointerType: "mouse" };
  track.setPointerCapture = () => {};
  track.hasPointerCapture = () => true;
  fireEvent.pointerMove(track, at);
  fireEvent.pointerDown(track, at);
  fireEvent.pointerUp(track, at);
}

afterEach(() => {
  cleanup();
  vi.restoreAllMocks();
  vi.unstubAllGlobals();
  useRun.setState({ experiment: null, status: null, link: { state: "connecting" } });
  useNotices.setState({ notices: [] });
});

test("a click at an earlier time goes back", () => {
  const call = vi.spyOn(wire, "call").mockResolvedValue({});
  click("paused", 0.8);
  expect(call).toHaveBeenCalledWith("/cockpit/seek", { t_s: 0.8 });
  expect(useNotices.getState().notices).toEqual([]);
});

test("a click while the run is busy is refused aloud, as its tip is gone by then", () => {
  const call = vi.spyOn(wire, "call").mockResolvedValue({});
  click("busy", 0.8);
  expect(call).not.toHaveBeenCalled();
  expect(useNotices.getState().notices.map(({ text }) => text)).toEqual(["The run is busy."]);
});
