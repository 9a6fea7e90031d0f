import type { Trace } from "../state/traces";
import type { Device, Experiment, TopicInfo } from "../state/types";
import { CURVE_COLOURS } from "./palette";

/** A curve as it is shown: in words, and in the colour of this number. */
export interface Shown {
  trace: Trace;
  label: string;
  colour: number;
}

/** Curves that share an axis: the devices of one quantity, or the fields of one topic. */
export interface Group {
  title: string;
  curves: Shown[];
}

const quantityOf = ({ topic, unit }: Device): string => {
  const quantity = topic.slice(topic.lastIndexOf("/") + 1).replaceAll("_", " ");
  return unit ? `${quantity} (${unit})` : quantity;
};

/** The last part of a device's name, or all of it where another device has the same last part. */
function shortName({ name }: Device, devices: readonly Device[]): string {
  const last = name.slice(name.lastIndexOf("/") + 1);
  const same = devices.filter((one) => one.name === last || one.name.endsWith(`/${last}`));
  return same.length > 1 ? name : last;
}

/** A path with the name of its last item instead of the number, where the topic names its items. */
function namedPath({ topic, path }: Trace, topics: readonly TopicInfo[]): string {
  const names = topics.find(({ name }) => name === topic)?.elements ?? [];
  return path.replace(/\[(\d+)\]$/, (number, at) => (names[at] === undefined ? number : `.${names[at]}`));
}

/** The group and the words of a curve. */
function describe(trace: Trace, devices: readonly Device[], topics: readonly TopicInfo[]) {
  const { topic, path } = trace;
  const device = devices.find((one) => one.topic === topic);
  if (!device) return { title: topic, label: namedPath(trace, topics).replace(/^data\./, "") };
  const index = device.neurons.length > 1 && path !== "data[0]" ? path.replace("data", "") : "";
  return { title: quantityOf(device), label: shortName(device, devices) + index };
}

/** The curves by axis, both in the order in which they were added. Each axis begins with the first colour. */
export function groupsOf(
  traces: readonly Trace[],
  devices: readonly Device[],
  topics: readonly TopicInfo[],
): Group[] {
  const groups = new Map<string, Group>();
  for (const trace of traces) {
    const { title, label } = describe(trace, devices, topics);
    const group = groups.get(title) ?? { title, curves: [] };
    groups.set(title, group);
    group.curves.push({ trace, label, colour: group.curves.length % CURVE_COLOURS.length });
  }
  return [...groups.values()];
}

/** More curves than these are not shown unasked, and no more on one axis than there are colours. */
const MOST = 12;
const MOST_OF_AN_AXIS = CURVE_COLOURS.length;

/** The curves that tell of a run: what devices read, the commands that drive robots, what devices feed in. */
export function mainTraces({ devices, robots, topics }: Experiment): Trace[] {
  const commands = topics.filter(({ type }) => /^geometry_msgs\/(msg\/)?Twist$/.test(type));
  const drives = (robots.length === 0 ? [] : commands).flatMap(({ name }) =>
    ["linear.x", "angular.z"].map((path) => ({ topic: name, path })),
  );
  const sinks = devices.filter(({ kind }) => kind === "sink").map(({ topic }) => ({ topic, path: "data" }));
  const sources = devices
    .filter(({ kind }) => kind === "source")
    .map(({ topic }) => ({ topic, path: "data[0]" })); // most feed all their neurons the same
  return [...sinks, ...drives, ...sources];
}

/** The curves that a run shows at first: as many of them as are told apart. */
export function firstTraces(experiment: Experiment): Trace[] {
  const groups = groupsOf(mainTraces(experiment), experiment.devices, experiment.topics);
  const chosen = groups.flatMap(({ curves }) => curves.slice(0, MOST_OF_AN_AXIS));
  return chosen.map(({ trace }) => trace).slice(0, MOST);
}
