// @vitest-environment happy-dom
import { act, cleanup, fireEvent, render, screen } from "@testing-library/react";
import { afterEach, expect, test, vi } from "vitest";
import { useRun } from "../state/run";
import type { Experiment, Status } from "../state/types";
import { wire } from "../wire";
import { Seed } from "./Seed";

const show = (experiment: Partial<Experiment>) => {
  useRun.setState({
    link: { state: "open" },
    experiment: { seed: 7, source: "live", may_steer: true, ...experiment } as Experiment,
    status: { state: "paused" } as Status,
  });
  render(<Seed />);
};
const field = () => screen.getByRole<HTMLInputElement>("textbox", { name: "Seed" });

afterEach(() => {
  cleanup();
  vi.restoreAllMocks();
  useRun.setState({ experiment: null, status: null, link: { state: "connecting" } });
});

test("another seed begins again, and the same one or words do nothing", async () => {
  const call = vi.spyOn(wire, "call").mockResolvedValue({});
  show({});
  const submit = () => act(async () => void fireEvent.submit(field().form as HTMLFormElement));
  await submit();
  fireEvent.change(field(), { target: { value: "seven" } });
  expect(field().getAttribute("aria-invalid")).toBe("true");
  await submit();
  expect(call).not.toHaveBeenCalled();
  expect(screen.queryByRole("button", { name: "Begin again" })).toBeNull();
  fireEvent.change(field(), { target: { value: "12" } });
  expect(screen.getByRole("button", { name: "Begin again" })).toBeTruthy();
  await submit();
  expect(call).toHaveBeenCalledWith("/cockpit/reseed", { seed: 12 });
});

test("a watcher and a recording show the seed and do not change it", () => {
  show({ may_steer: false });
  expect(field().disabled).toBe(true);
  cleanup();
  show({ source: "recording" });
  expect(screen.queryByRole("textbox")).toBeNull();
  expect(document.body.textContent).toContain("7");
});
