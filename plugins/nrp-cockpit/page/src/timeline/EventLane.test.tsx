// @vitest-environment happy-dom
import { cleanup, render, screen } from "@testing-library/react";
import { afterEach, expect, test } from "vitest";
import type { TimelineData } from "../state/types";
import { EventLane } from "./EventLane";

afterEach(cleanup);

test("pushes have marks, and what is waited for covers none", () => {
  const data: TimelineData = {
    duration_s: 10,
    events: [
      { name: "left_red", t_s: 8, waits_for: "" },
      { name: "all_blue", t_s: null, waits_for: "the robot near the screen" },
    ],
    interventions: [],
    criteria: [],
    failures: [],
    snapshots: [],
    automatic_s: [],
    edits: [{ name: "husky pushed", t_s: 2 }],
  };
  render(<EventLane data={data} span={{ from_s: 0, to_s: 10 }} />);
  const [push, event, waiting] = screen.getAllByRole("listitem");
  expect(push?.textContent).toBe("husky pushed");
  expect([push?.style.left, event?.style.left]).toEqual(["20%", "80%"]);
  expect([event, waiting].map((one) => one?.style.maxWidth)).toEqual(["max(10px, 10%)", "max(28px, 10%)"]);
});
