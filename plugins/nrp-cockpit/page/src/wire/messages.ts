/**
 * The messages of a topic in the order of their times. The bytes: their number n as 64 bits, n times in ns as 64 bit
 * floats, n lengths as 32 bits, and the messages; little-endian.
 */
export class Messages {
  readonly times_ns: Float64Array;
  private readonly ends: Uint32Array;
  private readonly data: Uint8Array;

  constructor(readonly bytes: ArrayBuffer) {
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

export function fromBase64(text: string): Uint8Array<ArrayBuffer> {
  const characters = atob(text);
  const bytes = new Uint8Array(characters.length);
  for (let at = 0; at < bytes.length; at++) bytes[at] = characters.charCodeAt(at);
  return bytes;
}

/** A function takes only so many arguments. */
const AT_ONCE = 0x8000;

export function toBase64(bytes: Uint8Array): string {
  let characters = "";
  for (let at = 0; at < bytes.length; at += AT_ONCE)
    characters += String.fromCharCode(...bytes.subarray(at, at + AT_ONCE));
  return btoa(characters);
}

/** Some messages of a topic, after those that were asked for before. */
export interface Portion {
  /** The time from which the topic is known. */
  from_s: number;
  /** All messages until this time are here. */
  until_ns: number;
  /** Whether there are none after it. */
  is_all: boolean;
  /** As `Messages` reads them, in base64. */
  packed: string;
}
