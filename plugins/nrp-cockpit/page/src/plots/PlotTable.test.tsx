// @vitest-environment happy-dom
import { act, cleanup, render, screen, within } from "@testing-library/react";
import { afterEach, expect, test, vi } from "vitest";
import { PlotTable } from "./PlotTable";

afterEach(() => {
  cleanup();
  vi.useRealTimers();
});

test("a plot is read as a table that follows it", () => {
  vi.useFakeTimers();
  let value = "1.00";
  render(<PlotTable caption="Curves of x" columns={["Curve", "Now"]} rows={() => [["x", value]]} />);
  const table = screen.getByRole("table", { name: "Curves of x" });
  const row = () => within(table).getByRole("row", { name: /^x/ });
  expect(within(table).getByRole("columnheader", { name: "Now" })).toBeTruthy();
  expect(within(row()).getByRole("rowheader").textContent).toBe("x");
  expect(within(row()).getByRole("cell").textContent).toBe("1.00");
  value = "2.00";
  act(() => void vi.advanceTimersByTime(2100));
  expect(within(row()).getByRole("cell").textContent).toBe("2.00");
});
