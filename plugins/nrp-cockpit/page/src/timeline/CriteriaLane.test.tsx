// @vitest-environment happy-dom
import { cleanup, fireEvent, render, screen } from "@testing-library/react";
import { afterEach, expect, test } from "vitest";
import { useNotices } from "../state/notices";
import { useTraces } from "../state/traces";
import { CriteriaLane } from "./CriteriaLane";

afterEach(() => {
  cleanup();
  useTraces.setState({ traces: [], chosen: false });
});

test("a criterion that is not met says why, and is a button so that a click goes to no other time", () => {
  const reason = "0.6 m, more than 0.5 m";
  const criteria = [
    { name: "stops", passed: false, from_s: 9, to_s: 10, text: reason },
    { name: "starts", passed: true, from_s: 0, to_s: 1, text: "1.2 m" },
  ];
  render(<CriteriaLane criteria={criteria} span={{ from_s: 0, to_s: 10 }} />);
  const [button] = screen.getAllByRole("button");
  expect(button?.textContent).toContain(`stops, not met: ${reason}`);
  expect(button?.querySelector(".hidden-text")).toBeNull();
  expect(screen.getAllByRole("button")).toHaveLength(1);
});

test("a click on a failed criterion says its value, its limit and when it was decided, and adds its curve", () => {
  const curve = { topic: "/gaze/error", path: "data", limits: [0.5] };
  const one = { name: "stops", passed: false, from_s: 9, to_s: 10, text: "0.6 m, more than 0.5 m" };
  const criteria = [{ ...one, curve }];
  useNotices.setState({ notices: [] }); // other tests leave some
  render(<CriteriaLane criteria={criteria} span={{ from_s: 0, to_s: 10 }} />);
  fireEvent.click(screen.getByRole("button"));
  expect(useNotices.getState().notices.map(({ text }) => text)).toEqual([
    "stops, not met at 10.00 s, watched from 9.00 s: 0.6 m, more than 0.5 m",
  ]);
  expect(useTraces.getState().traces).toEqual([{ topic: "/gaze/error", path: "data" }]);
});

test("the words beside a failed criterion cover no other one", () => {
  const one = { passed: true, text: "" };
  const criteria = [
    { ...one, name: "stops", passed: false, from_s: 1, to_s: 1.2 },
    { ...one, name: "turns", from_s: 2, to_s: 4 },
  ];
  const { container } = render(<CriteriaLane criteria={criteria} span={{ from_s: 0, to_s: 10 }} />);
  const rows = [...container.querySelectorAll<HTMLElement>("li")].map((li) =>
    li.style.getPropertyValue("--row"),
  );
  expect(rows).toEqual(["0", "1"]);
});
