// @vitest-environment happy-dom
import { cleanup, fireEvent, render, screen } from "@testing-library/react";
import { afterEach, expect, test, vi } from "vitest";
import { useNotices } from "../state/notices";
import { Button } from "./Button";
import { Menu } from "./Menu";
import { Switch } from "./Switch";

const BUSY = "The run is busy.";
const notices = () => useNotices.getState().notices.map(({ text }) => text);

afterEach(() => {
  cleanup();
  useNotices.setState({ notices: [] });
});

test("a control that cannot be used now does nothing and says why", () => {
  const act = vi.fn();
  render(
    <>
      <Button disabled={BUSY} onClick={act}>
        Apply
      </Button>
      <Switch label="Active" on disabled={BUSY} onChange={act} />
      <Menu label="Reset" items={[{ label: "All", onSelect: act }]} disabled={BUSY}>
        Reset
      </Menu>
    </>,
  );
  for (const control of [screen.getByText("Apply"), screen.getByRole("switch"), screen.getByText("Reset")]) {
    useNotices.setState({ notices: [] });
    fireEvent.click(control);
    expect(notices()).toEqual([BUSY]);
  }
  expect(act).not.toHaveBeenCalled();
  expect(screen.queryByRole("menu")).toBeNull();
});

test("an entry of a menu that cannot be chosen says why, and the menu stays", () => {
  const act = vi.fn();
  render(
    <Menu label="Panel" items={[{ label: "Close", disabled: "It is the last panel.", onSelect: act }]}>
      Panel
    </Menu>,
  );
  fireEvent.click(screen.getByText("Panel"));
  fireEvent.click(screen.getByRole("menuitem", { name: "Close" }));
  expect(notices()).toEqual(["It is the last panel."]);
  expect(act).not.toHaveBeenCalled();
  expect(screen.getByRole("menu")).toBeTruthy();
});
