// @vitest-environment happy-dom
import { cleanup, fireEvent, render, screen } from "@testing-library/react";
import { afterEach, expect, test, vi } from "vitest";
import { CellsMenu } from "./CellsMenu";

afterEach(cleanup);

const LOOK = { kind: "spikes", order: "number", each: false } as const;

function choose(item: string) {
  const [onLook, onZoom] = [vi.fn(), vi.fn()];
  render(<CellsMenu look={LOOK} onLook={onLook} onZoom={onZoom} />);
  fireEvent.click(screen.getByRole("button", { name: "Cells in the plot" }));
  fireEvent.click(screen.getByRole("menuitem", { name: item }));
  cleanup();
  return { look: onLook.mock.calls[0]?.[0], zoom: onZoom.mock.calls[0]?.[0] };
}

test("order, heat and height of the cells are chosen one by one", () => {
  expect(choose("Active cells first, silent ones hidden").look).toEqual({ ...LOOK, order: "active" });
  expect(choose("Heat of cells").look).toEqual({ ...LOOK, each: true });
  expect(choose("Fewer cells, higher").zoom).toBeLessThan(1);
  expect(choose("More cells, lower").zoom).toBeGreaterThan(1);
  expect(choose("All cells").zoom).toBeNull();
});

test("what is chosen is ticked", () => {
  render(<CellsMenu look={{ ...LOOK, order: "active" }} onLook={vi.fn()} onZoom={vi.fn()} />);
  fireEvent.click(screen.getByRole("button", { name: "Cells in the plot" }));
  const ticked = screen.getAllByRole("menuitem").filter((item) => item.querySelector("svg"));
  const words = ticked.map((item) => item.textContent);
  expect(words).toContain("Active cells first, silent ones hidden");
  expect(words).not.toContain("By number");
});
