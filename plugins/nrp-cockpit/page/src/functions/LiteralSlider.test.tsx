// @vitest-environment happy-dom
import { act, cleanup, fireEvent, render, screen } from "@testing-library/react";
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { useRun } from "../state/run";
import type { Experiment, SourceFile, Status } from "../state/types";
import { wire } from "../wire";
import { LiteralSlider } from "./LiteralSlider";
import { apply, edit, useFunctions } from "./store";

const path = "/x/steer.py";
const source = "RATE = 250.0\nother = 1\n";
const file: SourceFile = { path, source, language: "python", editable: true };
const literal = { from: 7, to: 12, line: 1, value: 250, whole: false };
const applied: unknown[] = [];

beforeEach(() => {
  vi.useFakeTimers();
  applied.length = 0;
  const experiment = { may_steer: true } as Experiment;
  useRun.setState({ link: { state: "open" }, experiment, status: { state: "running" } as Status });
  useFunctions.setState({ files: [file], drafts: {}, bases: {}, open: path, literal, slid: null });
  vi.spyOn(wire, "call").mockImplementation(async (name, request) => {
    applied.push([name.replace("/cockpit/functions/", ""), request]);
    return { applied: true, findings: [] };
  });
});
afterEach(() => {
  cleanup();
  vi.useRealTimers();
  vi.restoreAllMocks();
});

const move = async (value: string) => {
  fireEvent.change(screen.getByRole("slider", { name: "line 1 of steer.py" }), { target: { value } });
  await act(async () => vi.advanceTimersByTimeAsync(0));
};

test("the run takes a number at once, and one check follows when the slider rests", async () => {
  render(<LiteralSlider path={path} />);
  await move("125");
  const files = { [path]: "RATE = 125.0\nother = 1\n" };
  expect(applied).toEqual([["apply", { files, base: { [path]: source }, check: false }]]);
  await act(async () => vi.advanceTimersByTimeAsync(2000));
  expect(applied.slice(1)).toEqual([["recheck", {}]]);
  expect(useFunctions.getState().drafts).toEqual({});
});

test("while another edit waits, the slider only writes", async () => {
  edit(path, `${source}unfinished(\n`);
  render(<LiteralSlider path={path} />);
  await move("125");
  expect(applied).toEqual([]);
  expect(useFunctions.getState().drafts[path]).toBe("RATE = 125.0\nother = 1\nunfinished(\n");
  expect(screen.getByText("waits for Apply")).toBeTruthy();
});

test("a number that the run refused does not keep the next one from being tried", async () => {
  vi.mocked(wire.call).mockImplementationOnce(async () => ({ applied: false, findings: [] }));
  render(<LiteralSlider path={path} />);
  await move("0");
  act(() => useFunctions.setState({ literal: { ...literal, to: 10, value: 0 } }));
  await act(async () => vi.advanceTimersByTimeAsync(150));
  await move("50");
  expect(applied.at(-1)).toMatchObject(["apply", { files: { [path]: "RATE = 50.0\nother = 1\n" } }]);
});

test("what is edited while the run takes the drafts is sent after them", async () => {
  let taken = () => {};
  const answer = { applied: true, findings: [] };
  vi.mocked(wire.call).mockImplementationOnce(
    () => new Promise((resolve) => (taken = () => resolve(answer))),
  );
  edit(path, "RATE = 1.0\n");
  const first = apply();
  await Promise.resolve();
  edit(path, "RATE = 2.0\n");
  const second = apply();
  taken();
  await Promise.all([first, second]);
  expect(applied).toEqual([
    ["apply", { files: { [path]: "RATE = 2.0\n" }, base: { [path]: "RATE = 1.0\n" }, check: true }],
  ]);
  expect(useFunctions.getState().drafts).toEqual({});
});
