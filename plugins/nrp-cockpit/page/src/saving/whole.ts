import { addSpikes } from "../plots/spikeStore";
import { TimeRing } from "../plots/timeRing";
import { addValue } from "../plots/traceStore";
import type { Trace } from "../state/traces";
import { hearAll } from "../wire";
import type { Column } from "./csv";

/** All numbers of a series that the server knows, and since when it knows them; null: nothing is known of it. */
export interface Whole extends Column {
  from_s: number | null;
}

/** Of 16 million numbers the last are kept: more do not fit into the memory of a page. */
const MOST = 2 ** 24;

export async function wholeCurve(name: string, { topic, path }: Trace): Promise<Whole> {
  const values = new TimeRing(MOST);
  const from_s = await hearAll(topic, addValue(path, values));
  return { name, values, from_s: since(values, from_s) };
}

export async function wholeSpikes(label: string): Promise<Whole> {
  const values = new TimeRing(MOST);
  const from_s = await hearAll(`/brain/${label}/spikes`, addSpikes(values));
  return { name: label, values, from_s: since(values, from_s) };
}

const since = (values: TimeRing, from_s: number | null) => (values.isFull ? values.timeAt(0) : from_s);
