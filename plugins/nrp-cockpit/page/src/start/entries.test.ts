import { expect, test } from "vitest";
import type { Entry } from "../state/start";
import { partsOf, sectionsOf } from "./entries";

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

test("entries are found by words of their name, text and engines, in any order", () => {
  const entries = [
    entry("fly", { text: "It tastes sugar.", engines: ["event", "mujoco"] }),
    entry("./visit", { kind: "recording", installed: false, text: "fly, finished" }),
    entry("./rate.sweep", { kind: "sweep", installed: false }),
  ];
  const names = (search: string) =>
    sectionsOf(entries, search).map((one) => one.entries.map(({ name }) => name));
  expect(names("")).toEqual([["./visit"], ["./rate.sweep"], ["fly"], []]);
  expect(names("MUJOCO sugar")).toEqual([["fly"]]);
  expect(names("fly")).toEqual([["./visit"], ["fly"]]);
  expect(names("bee")).toEqual([]);
});

test("a variant is told from its experiment, and a folder is no variant", () => {
  expect(partsOf(entry("fly/silenced"))).toEqual({ name: "fly", variant: "silenced" });
  expect(partsOf(entry("./my/fly.yaml", { installed: false }))).toEqual({ name: "my/fly.yaml", variant: "" });
});
