import { Calls } from "./calls";
import { type Channel, readBinary, type ServerText, writeClientMessage } from "./frames";
import type { Link, Listener, Source } from "./socket";
import { type Handler, Subscriptions } from "./subscriptions";

/** The page's one connection to its source: topics in, services and topics out. It outlives lost sockets. */
export class Wire {
  private readonly channels = new Map<number, Channel>();
  private readonly outgoing = new Map<string, number>();
  private readonly linkListeners = new Set<(link: Link) => void>();
  private readonly withdrawnListeners = new Set<(topic: string) => void>();
  private readonly source: Source;
  private readonly subscriptions: Subscriptions;
  private readonly calls: Calls;

  constructor(connect: (listener: Listener) => Source) {
    this.source = connect({
      onLink: (link) => this.linked(link),
      onData: (data) => (typeof data === "string" ? this.text(JSON.parse(data)) : this.binary(data)),
    });
    this.subscriptions = new Subscriptions((message) => this.source.send(JSON.stringify(message)));
    this.calls = new Calls((data) => this.source.send(data));
  }

  open(): void {
    this.source.open();
  }

  close(): void {
    this.source.close();
  }

  onLink(listener: (link: Link) => void): () => void {
    this.linkListeners.add(listener);
    return () => this.linkListeners.delete(listener);
  }

  /** Calls back with each topic that the server offers no more. */
  onWithdrawn(listener: (topic: string) => void): void {
    this.withdrawnListeners.add(listener);
  }

  /**
   * Hears a topic until the returned function is called. `every`: all messages, in order; `latest`: at most one a
   * drawn frame. A topic that the server does not offer yet is heard as soon as it does.
   */
  subscribe<T>(topic: string, handler: Handler<T>, kind: "every" | "latest" = "every"): () => void {
    const channel = [...this.channels.values()].find((one) => one.topic === topic);
    return this.subscriptions.add(topic, handler as Handler, kind, channel);
  }

  /** Has the server send again what it remembers of a topic, unless it is about to do so. */
  recall(topic: string): void {
    this.subscriptions.recall(topic);
  }

  /** Does not deliver the message of a topic that waits for the next frame, because it is no longer true. */
  skip(topic: string): void {
    this.subscriptions.skip(topic);
  }

  /** Calls a service; the promise fails with the server's one sentence. */
  call<T = object>(name: string, request: object = {}): Promise<T> {
    return this.calls.call(name, request) as Promise<T>;
  }

  /** Publishes a message, written as JSON, on a topic of the run; `type` as in `std_msgs/ColorRGBA`. */
  publish(topic: string, type: string, value: object): void {
    let id = this.outgoing.get(topic);
    if (id === undefined) {
      id = this.outgoing.size + 1;
      this.outgoing.set(topic, id);
      this.send({ op: "advertise", channels: [{ id, topic, encoding: "json", schemaName: type }] });
    }
    this.source.send(writeClientMessage(id, value));
  }

  /** The channels that the server offers now. */
  offered(): Channel[] {
    return [...this.channels.values()];
  }

  private send(message: object): void {
    this.source.send(JSON.stringify(message));
  }

  private linked(link: Link): void {
    if (link.state !== "open") {
      this.channels.clear();
      this.outgoing.clear();
      this.subscriptions.reset();
      this.calls.lost();
    } else this.calls.opened();
    for (const listener of this.linkListeners) listener(link);
  }

  private text(message: ServerText): void {
    switch (message.op) {
      case "advertise":
        for (const channel of message.channels) {
          this.channels.set(channel.id, channel);
          this.subscriptions.advertised(channel);
        }
        break;
      case "unadvertise":
        for (const id of message.channelIds) this.withdrawn(id);
        break;
      case "advertiseServices":
        this.calls.advertised(message.services);
        break;
      case "unadvertiseServices":
        this.calls.withdrawn(message.serviceIds);
        break;
      case "serviceCallFailure":
        this.calls.failed(message);
        break;
      default: // serverInfo and status: the cockpit's own channels say all that the page shows
    }
  }

  private withdrawn(id: number): void {
    const topic = this.channels.get(id)?.topic;
    this.channels.delete(id);
    this.subscriptions.withdrawn(id);
    if (topic) for (const listener of this.withdrawnListeners) listener(topic);
  }

  private binary(buffer: ArrayBuffer): void {
    const message = readBinary(buffer);
    if (message?.op === "message")
      this.subscriptions.message(message.subscriptionId, message.data, message.t_s);
    else if (message?.op === "response") this.calls.answered(message.callId, message.data);
  }
}
