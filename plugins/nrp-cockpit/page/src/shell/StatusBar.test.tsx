// @vitest-environment happy-dom
import { cleanup, render, screen } from "@testing-library/react";
import { afterEach, expect, test } from "vitest";
import { useRun } from "../state/run";
import type { Functions, Status, TransferFunction } from "../state/types";
import { Clock } from "../toolbar/Clock";
import { StatusBar } from "./StatusBar";

const BEGIN = {
  state: "paused",
  t_s: 0,
  wall_s: 0,
  real_time_factor: null,
  server_ms_per_step: null,
  share: null,
  dropped: 0,
} as Status;
const failure = { t_s: 2, message: "", traceback: "", stops: true };
const functionWith = (more: Partial<TransferFunction>) =>
  ({ name: "drive", active: true, failure: null, ...more }) as TransferFunction;

const show = (status: Partial<Status>, functions: TransferFunction[] = []) => {
  useRun.setState({ status: { ...BEGIN, ...status }, functions: { functions, files: [] } as Functions });
  render(
    <>
      <Clock />
      <StatusBar />
    </>,
  );
  return document.body.textContent;
};

afterEach(() => {
  cleanup();
  useRun.setState({ status: null, functions: null });
});

test("before the first step no speed, no share and no cost is a number", () => {
  const text = show({});
  expect(text).toContain("–real time");
  expect(text).not.toMatch(/%|a step|dropped/);
});

test("what was measured is shown", () => {
  const share = { brain: 0.25, world: 0.25, functions: 0.25, loop: 0.25 };
  const text = show({ real_time_factor: 0.5, server_ms_per_step: 0.7, share, dropped: 3 });
  for (const part of ["0.50×", "brain 25 %"]) expect(text).toContain(part);
  expect(text).not.toMatch(/dropped|0\.7/);
});

test("functions that do not run are counted by the reason", () => {
  show({ state: "failed" }, [functionWith({ failure }), functionWith({ active: false })]);
  const links = screen.getAllByRole("link").map((one) => one.textContent);
  expect(links).toEqual(["1 function failed", "1 function switched off"]);
  cleanup();
  show({ state: "running" }, [functionWith({ failure })]);
  expect(screen.getByRole("link").textContent).toBe("1 function in quarantine");
});

test("nobody reads of a live run before the server has described one", () => {
  useRun.setState({ link: { state: "open" }, status: null });
  render(<StatusBar />);
  expect(screen.getByRole("status").textContent).toBe("Loading");
  cleanup();
  show({});
  expect(screen.getByRole("status").textContent).toBe("Live on this machine");
});
