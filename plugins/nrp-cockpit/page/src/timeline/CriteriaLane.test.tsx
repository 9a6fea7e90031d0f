// @vitest-environment happy-dom
import { render, screen } from "@testing-library/react";
import { expect, test } from "vitest";
import { CriteriaLane } from "./CriteriaLane";

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
