import type { Trace } from "../state/traces";
import type { Device, TopicInfo } from "../state/types";
import type { Channel } from "../wire";
import { numericPaths } from "./messagePath";

/** Types whose numbers are pictures, scenes or events: no curve shows them well. */
const NO_CURVES = /\/(Image|CompressedImage|PointCloud2|SceneUpdate|TFMessage|Spikes)$/;

const isList = (schemaName: string) => schemaName.endsWith("MultiArray");

/** All curves that a run offers: devices first, then topics by name. */
export function offeredTraces(
  channels: readonly Channel[],
  devices: readonly Device[],
  topics: readonly TopicInfo[],
): Trace[] {
  const lengths = new Map([
    ...topics
      .filter(({ elements }) => elements.length > 0)
      .map(({ name, elements }) => [name, elements.length] as const),
    ...devices.map(({ topic, neurons }) => [topic, neurons.length] as const),
  ]);
  const read = new Set(devices.map(({ topic }) => topic));
  const rank = ({ topic }: Channel) => (read.has(topic) ? 0 : topic.endsWith("/color") ? 2 : 1);
  return channels
    .filter(({ encoding, schemaName }) => encoding === "cdr" && !NO_CURVES.test(schemaName))
    .toSorted((a, b) => rank(a) - rank(b) || a.topic.localeCompare(b.topic))
    .flatMap(({ topic, schema, schemaName }) =>
      numericPaths(schema, (path) => (path.includes(".") ? 1 : (lengths.get(topic) ?? 1)))
        .filter((path) => !(isList(schemaName) && path.includes("."))) // the layout of a list is no number of it
        .map((path) => ({ topic, path })),
    );
}
