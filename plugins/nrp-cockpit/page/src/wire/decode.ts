import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import { type Channel, textOf } from "./frames";

export type Decode = (data: DataView) => unknown;

const readers = new Map<string, MessageReader>();

function readerOf(channel: Channel): MessageReader {
  let reader = readers.get(channel.schema);
  if (!reader) {
    reader = new MessageReader(parse(channel.schema, { ros2: true }));
    readers.set(channel.schema, reader);
  }
  return reader;
}

/** How the payloads of a channel become values: JSON, or ROS 2 CDR by the channel's own definition. */
export function decoderOf(channel: Channel): Decode {
  if (channel.encoding === "json") return (data) => JSON.parse(textOf(data));
  if (channel.encoding === "cdr") {
    const reader = readerOf(channel);
    return (data) => reader.readMessage(data);
  }
  throw new Error(`${channel.topic}: the encoding '${channel.encoding}' is neither 'json' nor 'cdr'`);
}
