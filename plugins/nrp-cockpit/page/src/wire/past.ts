import { decoderOf } from "./decode";
import { fromBase64, Messages, type Portion } from "./messages";
import { wire } from "./wire";

/** What the server says before it sends the past of a topic that the page subscribed to. */
export interface Past {
  topic: string;
  /** The time from which the topic is known. */
  from_s: number;
  /** How many messages of it follow. */
  count: number;
  /** Whether all that was known before is invalid. */
  new: boolean;
}

export const PAST = "/cockpit/past";

/** Calls back before the past of any topic comes. */
export const onPast = (listener: (past: Past) => void): (() => void) => wire.subscribe<Past>(PAST, listener);

/**
 * Gives all messages of a topic that the server knows, also those that were never sent to this page, and returns the
 * time from which they are known; null: the topic is not offered.
 */
export async function hearAll<T>(
  topic: string,
  handler: (message: T, t_s: number) => void,
): Promise<number | null> {
  const channel = wire.offered().find((one) => one.topic === topic);
  if (!channel) return null;
  const decode = decoderOf(channel);
  for (let after_ns = -1; ; ) {
    const portion = await wire.call<Portion>("/cockpit/messages", { topic, after_ns });
    const messages = new Messages(fromBase64(portion.packed).buffer);
    messages.times_ns.forEach((t_ns, at) => {
      const { buffer, byteOffset, byteLength } = messages.at(at);
      handler(decode(new DataView(buffer, byteOffset, byteLength)) as T, t_ns / 1e9);
    });
    if (portion.is_all) return portion.from_s;
    after_ns = portion.until_ns;
  }
}
