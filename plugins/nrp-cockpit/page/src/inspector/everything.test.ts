import { expect, it } from "vitest";
import type { Body, Device, Population, Projection } from "../state/types";
import { bodiesOf, groupsOf, populationsOf } from "./everything";

const body = (name: string, fixed: boolean) => ({ name, static: fixed }) as Body;

it("lists the bodies that move before those that stand", () => {
  const found = bodiesOf({ bodies: [body("room", true), body("husky", false), body("screen", true)] });
  expect(found.map(({ name, note }) => [name, note])).toEqual([
    ["husky", "moves"],
    ["room", "fixed"],
    ["screen", "fixed"],
  ]);
});

it("lists under each population the projections that leave it", () => {
  const populations = [
    { label: "eyes", size: 5 },
    { label: "wheels", size: 2 },
  ] as Population[];
  const projections = [{ id: "p1", pre: "eyes", post: "wheels", excites: false }] as Projection[];
  const [eyes, wheels] = populationsOf({ populations, projections, devices: [] });
  expect(eyes?.parts?.map(({ name, to }) => [name, to])).toEqual([
    ["⊣ wheels", { kind: "projection", id: "p1" }],
  ]);
  expect(wheels?.parts).toEqual([]);
});

it("tells several projections to the same cells apart", () => {
  const populations = [{ label: "circuit", size: 8 }] as Population[];
  const [one, other] = ["[2] to [7]", "[3] to [6]"];
  const projections = [one, other].map((id) => ({
    id,
    label: id,
    pre: "circuit",
    post: "circuit",
    excites: true,
  }));
  const [circuit] = populationsOf({ populations, projections: projections as Projection[], devices: [] });
  expect(circuit?.parts?.map(({ name }) => name)).toEqual([`→ ${one}`, `→ ${other}`]);
  const unnamed = projections.map((each) => ({ ...each, label: `circuit→circuit ${each.id}` }));
  const [same] = populationsOf({ populations, projections: unnamed as Projection[], devices: [] });
  expect(same?.parts?.map(({ name }) => name)).toEqual(["→ circuit (1)", "→ circuit (2)"]);
});

it("names projections after the cells of the robot at their ends, and folds many to the same cells", () => {
  const populations = [{ label: "circuit", size: 9, first: 10 }] as Population[];
  const projections = Array.from({ length: 5 }, (_, at) => ({
    id: `p${at}`,
    label: `[${at}] to [7]`,
    pre: "circuit",
    post: "circuit",
    excites: true,
    edges: [[at, 7, 1]],
  })) as unknown as Projection[];
  const devices = [
    { name: "eye/red_left_eye", neurons: [12] },
    { name: "wheels/right_wheel", neurons: [17] },
  ] as Device[];
  const [circuit] = populationsOf({ populations, projections, devices });
  expect(circuit?.parts?.map(({ name, note }) => [name, note])).toEqual([["→ circuit", "5 projections"]]);
  expect(circuit?.parts?.[0]?.folded?.map(({ name }) => name)).toEqual([
    "→ [0] to [7]",
    "→ [1] to [7]",
    "red left eye → right wheel",
    "→ [3] to [7]",
    "→ [4] to [7]",
  ]);
});

it("lists the groups of cells with their sizes, over all populations", () => {
  const cells = {
    eyes: [
      [0, 2],
      [4, 5],
    ],
    wheels: [[0, 1]],
  } as Record<string, [number, number][]>;
  expect(groupsOf({ groups: [{ name: "left", cells, own: cells }] })).toEqual([
    { name: "left", note: "4", to: { kind: "group", name: "left" } },
  ]);
});
