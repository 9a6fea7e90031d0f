import type { Extent } from "./playing";

/** How much of a topic belongs to a moment: its last message, all changes so far, or its last seconds. */
export type Shown = "last" | "changes" | "seconds";

/** What a page says of the recording that it holds; `nrp_cockpit/sharing` writes it. */
export interface About extends Extent {
  topics: { topic: string; schemaName: string; schema: string; shown: Shown }[];
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

export function fromBase64(text: string): Uint8Array<ArrayBuffer> {
  const characters = atob(text);
  const bytes = new Uint8Array(characters.length);
  for (let at = 0; at < bytes.length; at++) bytes[at] = characters.charCodeAt(at);
  return bytes;
}

async function unpacked(id: string): Promise<ArrayBuffer> {
  const text = document.getElementById(id)?.textContent;
  if (!text) throw new Error(`The file lacks its part '${id}'.`);
  const packed = new Blob([fromBase64(text)]).stream();
  return new Response(packed.pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
}

/**
 * The messages of a topic in the order of their times. The bytes: their number n as 64 bits, n times in ns as 64 bit
 * floats, n lengths as 32 bits, and the messages; little-endian.
 */
export class Messages {
  readonly times_ns: Float64Array;
  private readonly ends: Uint32Array;
  private readonly data: Uint8Array;

  constructor(bytes: ArrayBuffer) {
    const count = new DataView(bytes).getUint32(0, true);
    this.times_ns = new Float64Array(bytes, 8, count);
    let end = 0;
    this.ends = new Uint32Array(bytes, 8 + 8 * count, count).map((length) => {
      end += length;
      return end;
    });
    this.data = new Uint8Array(bytes, 8 + 12 * count);
  }

  /** How many messages have come until a time, with it. */
  until(t_ns: number): number {
    let [low, high] = [0, this.times_ns.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if ((this.times_ns[middle] as number) <= t_ns) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  /** The bytes of a message. */
  at(number: number): Uint8Array {
    return this.data.subarray(this.ends[number - 1] ?? 0, this.ends[number]);
  }
}
