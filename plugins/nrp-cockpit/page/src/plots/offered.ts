import type { Trace } from "../state/traces";
import type { Device } from "../state/types";
import type { Channel } from "../wire";
import { numericPaths } from "./messagePath";

/** Types whose numbers are pictures, scenes or events: no curve shows them well. */
const NO_CURVES = /\/(Image|CompressedImage|PointCloud2|SceneUpdate|TFMessage|Spikes)$/;

/** All curves that a run offers: devices first, then topics by name. */
export function offeredTraces(channels: readonly Channel[], devices: readonly Device[]): Trace[] {
  const lengths = new Map(devices.map(({ topic, neurons }) => [topic, neurons.length]));
  const rank = ({ topic }: Channel) => (lengths.has(topic) ? 0 : topic.endsWith("/color") ? 2 : 1);
  return channels
    .filter(({ encoding, schemaName }) => encoding === "cdr" && !NO_CURVES.test(schemaName))
    .toSorted((a, b) => rank(a) - rank(b) || a.topic.localeCompare(b.topic))
    .flatMap(({ topic, schema }) =>
      numericPaths(schema, (path) => (path === "data" ? (lengths.get(topic) ?? 1) : 1)).map((path) => ({
        topic,
        path,
      })),
    );
}
