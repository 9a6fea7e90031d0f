import { fromBase64, Messages } from "./messages";
import type { Extent } from "./playing";

/** How much of a topic belongs to a moment: its last message, all changes so far, or its last seconds. */
export type Shown = "last" | "changes" | "seconds";

/** What a page says of the recording that it holds; `nrp_cockpit/sharing` writes it. */
export interface About extends Extent {
  topics: { topic: string; schemaName: string; schema: string; shown: Shown }[];
  /** The time at which the page opens. */
  opens_ns: number;
  /** What a server reports on `/cockpit/NAME`. */
  reports: Record<string, object>;
  layout: object;
  /** All services of a server that plays the recording, and why those that change a run are refused. */
  services: string[];
  refusal: string;
  /** The message, in base64, that removes all of a scene. */
  clear: string;
}

const ABOUT = "nrp-recording";
const topicId = (number: number) => `nrp-topic-${number}`;

/** Whether this page holds a recording, and needs no server. */
export const isPlayed = (): boolean =>
  typeof document !== "undefined" && document.getElementById(ABOUT) !== null;

export const readAbout = async (): Promise<About> =>
  JSON.parse(new TextDecoder().decode(await unpacked(ABOUT)));

/** Reads the messages of a topic, which are unpacked when they are first shown. */
export const readMessages = async (number: number): Promise<Messages> =>
  new Messages(await unpacked(topicId(number)));

async function unpacked(id: string): Promise<ArrayBuffer> {
  const text = document.getElementById(id)?.textContent;
  if (!text) throw new Error(`The file lacks its part '${id}'.`);
  const packed = new Blob([fromBase64(text)]).stream();
  return new Response(packed.pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
}
