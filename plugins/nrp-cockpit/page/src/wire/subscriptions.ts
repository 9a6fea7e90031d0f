import { type Decode, decoderOf } from "./decode";
import type { Channel } from "./frames";

/** Gets a decoded message and the simulated time at which it was sent. */
export type Handler<T = unknown> = (message: T, t_s: number) => void;

interface Topic {
  every: Set<Handler>;
  latest: Set<Handler>;
  channel: Channel | null;
  subscriptionId: number;
  /** Whether something came for this subscription. */
  begun: boolean;
  decode: Decode | null;
  waiting: { data: DataView; t_s: number } | null;
}

type Send = (message: object) => void;

/**
 * Which topics the page wants: subscribed at the server while at least one handler is there, and again after a
 * reconnect. A `latest` handler gets at most one message a drawn frame, so that a page too slow for a topic skips.
 */
export class Subscriptions {
  private readonly topics = new Map<string, Topic>();
  private readonly byId = new Map<number, Topic>();
  private nextId = 1;
  private frame = 0;

  constructor(private readonly send: Send) {}

  add(name: string, handler: Handler, kind: "every" | "latest", channel: Channel | undefined): () => void {
    const topic = this.topics.get(name) ?? newTopic();
    this.topics.set(name, topic);
    topic[kind].add(handler);
    if (channel && topic.channel === null) this.bind(topic, channel);
    return () => {
      topic[kind].delete(handler);
      if (topic.every.size + topic.latest.size > 0 || this.topics.get(name) !== topic) return;
      this.topics.delete(name);
      if (topic.channel) this.send({ op: "unsubscribe", subscriptionIds: [topic.subscriptionId] });
      this.byId.delete(topic.subscriptionId);
    };
  }

  advertised(channel: Channel): void {
    const topic = this.topics.get(channel.topic);
    if (topic) this.bind(topic, channel);
  }

  recall(name: string): void {
    const topic = this.topics.get(name);
    if (!topic?.channel || !topic.begun) return;
    const { channel, subscriptionId } = topic;
    this.send({ op: "unsubscribe", subscriptionIds: [subscriptionId] });
    this.bind(topic, channel);
  }

  /** Drops the message of a topic that waits for the next frame. */
  skip(name: string): void {
    const topic = this.topics.get(name);
    if (topic) topic.waiting = null;
  }

  withdrawn(channelId: number): void {
    for (const topic of this.topics.values()) if (topic.channel?.id === channelId) this.unbind(topic);
  }

  /** Forgets what the server knew: a new connection starts from nothing. */
  reset(): void {
    for (const topic of this.topics.values()) this.unbind(topic);
  }

  message(subscriptionId: number, data: DataView, t_s: number): void {
    const topic = this.byId.get(subscriptionId);
    if (!topic?.decode) return;
    topic.begun = true;
    if (topic.every.size > 0) deliver(topic.every, topic.decode(data), t_s);
    if (topic.latest.size === 0) return;
    topic.waiting = { data, t_s };
    this.frame ||= requestAnimationFrame(() => this.flush());
  }

  private flush(): void {
    this.frame = 0;
    for (const topic of this.topics.values()) {
      const { waiting, decode } = topic;
      topic.waiting = null;
      if (waiting && decode) deliver(topic.latest, decode(waiting.data), waiting.t_s);
    }
  }

  private bind(topic: Topic, channel: Channel): void {
    this.unbind(topic);
    topic.channel = channel;
    topic.decode = decoderOf(channel);
    topic.subscriptionId = this.nextId++;
    topic.begun = false;
    this.byId.set(topic.subscriptionId, topic);
    this.send({ op: "subscribe", subscriptions: [{ id: topic.subscriptionId, channelId: channel.id }] });
  }

  private unbind(topic: Topic): void {
    this.byId.delete(topic.subscriptionId);
    topic.channel = null;
    topic.decode = null;
    topic.waiting = null;
  }
}

const newTopic = (): Topic => ({
  every: new Set(),
  latest: new Set(),
  channel: null,
  subscriptionId: 0,
  begun: false,
  decode: null,
  waiting: null,
});

function deliver(handlers: Set<Handler>, message: unknown, t_s: number): void {
  for (const handler of [...handlers]) handler(message, t_s);
}
