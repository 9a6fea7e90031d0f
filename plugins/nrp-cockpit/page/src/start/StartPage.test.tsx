// @vitest-environment happy-dom
import { act, cleanup, fireEvent, render, screen, within } from "@testing-library/react";
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { type Entry, useStart } from "../state/start";
import { wire } from "../wire";
import StartPage from "./StartPage";

const entry = (name: string, more: Partial<Entry> = {}): Entry => ({
  kind: "experiment",
  name,
  installed: true,
  text: "",
  engines: [],
  error: "",
  picture: "",
  ...more,
});

beforeEach(() => {
  const entries = [
    entry("fly", { text: "It tastes sugar." }),
    entry("./broken.yaml", { installed: false, error: "not YAML" }),
    entry("./visit", { kind: "recording", installed: false }),
  ];
  useStart.setState({ isOpen: true, start: { folder: "/home", entries }, opening: null });
});
afterEach(() => {
  cleanup();
  vi.restoreAllMocks();
});

test("what can be opened is sorted by where it comes from, and found by words", () => {
  render(<StartPage />);
  const recordings = screen.getByRole("region", { name: "Recordings in this folder" });
  expect(within(recordings).getByRole("button", { name: "Open ./visit" })).toBeTruthy();
  expect(screen.getByRole("region", { name: "Sweeps in this folder" }).textContent).toContain(
    "There is none",
  );
  fireEvent.change(screen.getByRole("searchbox", { name: "Search" }), { target: { value: "sugar" } });
  expect(
    screen.getAllByRole("button", { name: /^Open / }).map((one) => one.getAttribute("aria-label")),
  ).toEqual(["Open fly"]);
});

test("a choice is opened once, and a broken one is not", async () => {
  let opened: () => void = () => undefined;
  const call = vi.spyOn(wire, "call").mockImplementation(
    () =>
      new Promise((resolve) => {
        opened = () => resolve({});
      }),
  );
  render(<StartPage />);
  fireEvent.click(screen.getByRole("button", { name: "Open ./broken.yaml" }));
  expect(call).not.toHaveBeenCalled();
  fireEvent.click(screen.getByRole("button", { name: "Open fly" }));
  fireEvent.click(screen.getByRole("button", { name: "Open ./visit" }));
  expect(call.mock.calls).toEqual([["/cockpit/start/open", { name: "fly" }]]);
  expect(screen.getByRole("main").getAttribute("aria-busy")).toBe("true");
  await act(async () => opened());
  expect(screen.getByRole("main").getAttribute("aria-busy")).toBe("false");
});

test("the files of experiments in the folder are read for pictures only after a click that says so", async () => {
  const call = vi.spyOn(wire, "call").mockResolvedValue({ type: "image/png", data: "AAAA" });
  const entries = [
    entry("arm", { picture: "arm" }),
    entry("./mine.yaml", { installed: false, picture: "mine" }),
  ];
  useStart.setState({ start: { folder: "/home", entries }, readsFiles: false });
  render(<StartPage />);
  await screen.findByAltText("The scene of arm");
  expect(call.mock.calls.map(([, request]) => request)).toEqual([{ name: "arm" }]);
  const folder = screen.getByRole("region", { name: "Experiments in this folder" });
  expect(folder.textContent).toContain("reads their robots, rooms and images, and executes nothing");
  fireEvent.click(within(folder).getByRole("button", { name: "Draw their scenes" }));
  await screen.findByAltText("The scene of ./mine.yaml");
  expect(call.mock.calls.at(-1)).toEqual([
    "/cockpit/start/picture",
    { name: "./mine.yaml", reads_files: true },
  ]);
  expect(within(folder).queryByRole("button", { name: "Draw their scenes" })).toBeNull();
});

test("entries that look the same have one picture, which is asked for once, and some have none", async () => {
  const call = vi.spyOn(wire, "call").mockImplementation(async (_name, request) => {
    if ((request as { name: string }).name === "worm") throw new Error("cannot be drawn");
    return { type: "image/png", data: "AAAA" };
  });
  const entries = [
    entry("husky", { picture: "a" }),
    entry("husky/bibi", { picture: "a" }),
    entry("rover", { picture: "a" }),
    entry("worm", { picture: "b" }),
    entry("empty"),
  ];
  useStart.setState({ start: { folder: "/home", entries } });
  render(<StartPage />);
  const image = await screen.findByAltText<HTMLImageElement>("The scene of husky");
  expect(image.src).toBe("data:image/png;base64,AAAA");
  await act(async () => undefined);
  expect(call.mock.calls.map(([, request]) => request)).toEqual([{ name: "husky" }, { name: "worm" }]);
  expect(screen.getAllByRole("img").length).toBe(2);
});

test("variants are folded under their experiment", () => {
  const entries = [entry("husky"), entry("husky/bibi"), entry("./husky/own", { installed: false })];
  useStart.setState({ start: { folder: "/home", entries } });
  render(<StartPage />);
  const installed = screen.getByRole("region", { name: "Installed experiments" });
  const [card] = within(installed).getAllByRole("listitem");
  expect(within(installed).getAllByRole("listitem")).toHaveLength(1);
  expect(card?.querySelector("details")?.textContent).toContain("1 variant");
  expect(card?.querySelector("details button")?.getAttribute("aria-label")).toBe("Open husky/bibi");
});
