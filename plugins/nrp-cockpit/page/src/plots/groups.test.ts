import { expect, test } from "vitest";
import type { Device, Experiment, TopicInfo } from "../state/types";
import { firstTraces, groupsOf, mainTraces } from "./groups";
import { offeredTraces } from "./offered";

const device = (name: string, kind: "sink" | "source", unit: string, neurons: number[]): Device => ({
  name,
  kind,
  unit,
  neurons,
  topic: `/brain/devices/${name}/${kind === "sink" ? "voltage" : "rate"}`,
  population: "circuit",
});
const devices = [
  device("eye/left", "source", "Hz", [0, 2]),
  device("wheel/left_wheel", "sink", "mV", [6]),
  device("wheel/right_wheel", "sink", "mV", [7]),
];
const run = {
  devices,
  robots: ["husky"],
  topics: [
    { name: "/husky/cmd_vel", type: "geometry_msgs/msg/Twist", direction: "in", unit: null, rate_hz: null },
    { name: "/husky/odom", type: "nav_msgs/msg/Odometry", direction: "out", unit: null, rate_hz: 50 },
  ],
} as unknown as Experiment;

test("a run shows at first what devices read, what drives its robot, and what devices feed in", () => {
  expect(firstTraces(run).map(({ topic, path }) => `${topic} ${path}`)).toEqual([
    "/brain/devices/wheel/left_wheel/voltage data",
    "/brain/devices/wheel/right_wheel/voltage data",
    "/husky/cmd_vel linear.x",
    "/husky/cmd_vel angular.z",
    "/brain/devices/eye/left/rate data[0]",
  ]);
  expect(firstTraces({ ...run, robots: [] }).some(({ topic }) => topic === "/husky/cmd_vel")).toBe(false);
});

test("devices of one quantity share an axis, and so do the fields of a topic", () => {
  const groups = groupsOf(firstTraces(run), devices, run.topics);
  expect(groups.map(({ title, curves }) => [title, ...curves.map(({ label }) => label)])).toEqual([
    ["voltage (mV)", "left_wheel", "right_wheel"],
    ["/husky/cmd_vel", "linear.x", "angular.z"],
    ["rate (Hz)", "left"],
  ]);
  expect(groups.map(({ curves }) => curves[0]?.colour)).toEqual([0, 0, 0]);
});

test("devices whose names end alike are told apart by their whole names", () => {
  const alike = [device("leg_1/lifting", "sink", "Hz", [1]), device("leg_2/lifting", "sink", "Hz", [2])];
  const [group] = groupsOf(firstTraces({ ...run, devices: alike, robots: [] }), alike, []);
  expect(group?.curves.map(({ label }) => label)).toEqual(["leg_1/lifting", "leg_2/lifting"]);
});

test("more curves on an axis than there are colours are left out at first", () => {
  const many = Array.from({ length: 9 }, (_, at) => device(`legs/${at}`, "sink", "Hz", [at]));
  const legs = { ...run, devices: many, robots: [] };
  expect([mainTraces(legs).length, firstTraces(legs).length]).toEqual([9, 6]);
});

const muscles = [{ name: "/arm/muscles/cmd", elements: ["flexor", "extensor"] }] as unknown as TopicInfo[];

test("all numbers are offered, devices first, but none of pictures", () => {
  const channel = (topic: string, schemaName: string, schema: string, encoding = "cdr") => ({
    id: 1,
    topic,
    schemaName,
    schema,
    encoding,
  });
  const LIST = "Layout layout\nfloat64[] data\n===\nMSG: std_msgs/Layout\nuint32 data_offset";
  const traces = offeredTraces(
    [
      channel("/husky/camera", "sensor_msgs/msg/Image", "uint32 width"),
      channel("/cockpit/status", "cockpit/status", "", "json"),
      channel("/a", "std_msgs/msg/Float64", "float64 data"),
      channel("/brain/devices/eye/left/rate", "std_msgs/msg/Float64MultiArray", "float64[] data"),
      channel("/arm/muscles/cmd", "std_msgs/msg/Float64MultiArray", LIST),
    ],
    devices,
    muscles,
  );
  expect(traces.map(({ topic, path }) => `${topic} ${path}`)).toEqual([
    "/brain/devices/eye/left/rate data[0]",
    "/brain/devices/eye/left/rate data[1]",
    "/a data",
    "/arm/muscles/cmd data[0]",
    "/arm/muscles/cmd data[1]",
  ]);
  const [, , group] = groupsOf(traces, devices, muscles);
  expect(group?.curves.map(({ label }) => label)).toEqual(["flexor", "extensor"]);
});
