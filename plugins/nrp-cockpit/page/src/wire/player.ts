import { type Channel, readServiceRequest, type ServiceRequest, writeMessage, writeResponse } from "./frames";
import { fromBase64, type Messages, type Portion, toBase64 } from "./messages";
import { Playing } from "./playing";
import { type About, readAbout, readMessages, type Shown } from "./recording";
import type { Listener, Source } from "./socket";

/** The time before a moment that is sent too, so that plots are not empty; as the server does it. */
const WINDOW_NS = 4e9;
const STATUS_MS = 100;
const STATUS = "status";
const PAST = "past";

interface Subscription {
  channel: Channel;
  shown: Shown;
  /** null until they are unpacked. */
  messages: Messages | null;
  /** How many messages of it the page has; -1: it was not sent anything yet. */
  sent: number;
}

type Arguments = Record<string, unknown>;

/**
 * Answers the page in place of a server, from the recording that the page holds: the same topics, reports and services
 * as of a server that plays it.
 */
export class Player implements Source {
  private about!: About;
  private time!: Playing;
  private clear = new Uint8Array();
  private channels: Channel[] = [];
  private readonly reported = new Map<number, string>();
  private readonly topics = new Map<number, Subscription>();
  private readonly read = new Map<number, Promise<Messages>>();
  private statusAt_ms = 0;
  private frame = 0;

  constructor(
    private readonly listener: Listener,
    private readonly recorded = { about: readAbout, messages: readMessages },
  ) {}

  open(): void {
    this.listener.onLink({ state: "connecting" });
    this.start().catch((error: Error) => this.listener.onLink({ state: "refused", reason: error.message }));
  }

  close(): void {
    this.time.pause();
  }

  /** Takes a message of the page, as a server would: what it answers comes later. */
  send(data: string | Uint8Array): boolean {
    queueMicrotask(() => this.take(data));
    return true;
  }

  private take(data: string | Uint8Array): void {
    if (typeof data !== "string") {
      const request = readServiceRequest(data);
      if (request) void this.answer(request);
      return;
    }
    const message = JSON.parse(data);
    if (message.op === "subscribe")
      for (const { id, channelId } of message.subscriptions) void this.subscribe(id, channelId);
    else if (message.op === "unsubscribe")
      for (const id of message.subscriptionIds) {
        this.reported.delete(id);
        this.topics.delete(id);
      }
  }

  private async start(): Promise<void> {
    this.about = await this.recorded.about();
    this.time = new Playing(this.about);
    this.time.seek(this.about.opens_ns);
    this.clear = fromBase64(this.about.clear);
    const { topics, reports, services } = this.about;
    const topical = topics.map((one) => ({ ...one, encoding: "cdr" }));
    const reporting = [...Object.keys(reports), PAST].map((name) => ({
      topic: `/cockpit/${name}`,
      encoding: "json",
      schemaName: name,
      schema: "{}",
    }));
    this.channels = [...topical, ...reporting].map((channel, id) => ({ id, ...channel }));
    this.listener.onLink({ state: "open" });
    this.say({ op: "advertise", channels: this.channels });
    this.say({ op: "advertiseServices", services: services.map((name, id) => ({ id, name })) });
  }

  // -- topics

  private async subscribe(id: number, channelId: number): Promise<void> {
    const channel = this.channels[channelId];
    if (!channel) return;
    const topic = this.about.topics[channelId];
    if (!topic) {
      const name = channel.schemaName;
      this.reported.set(id, name);
      if (name !== PAST) this.report(id, name);
      return;
    }
    const subscription: Subscription = { channel, shown: topic.shown, messages: null, sent: -1 };
    this.topics.set(id, subscription);
    subscription.messages = await this.messagesOf(channelId);
    if (this.topics.get(id) === subscription) this.show(id, subscription);
  }

  private messagesOf(channelId: number): Promise<Messages> {
    const known = this.read.get(channelId) ?? this.recorded.messages(channelId);
    this.read.set(channelId, known);
    return known;
  }

  /** Sends what belongs to this moment, whatever was sent before. */
  private show(id: number, one: Subscription): void {
    const { messages, shown } = one;
    if (!messages) return;
    const { now_ns } = this.time;
    const end = messages.until(now_ns);
    if (shown === "changes") {
      if (end < one.sent) this.message(id, now_ns, this.clear);
      if (end < one.sent || one.sent < 0) one.sent = 0;
    } else {
      const from_ns = shown === "last" ? now_ns : Math.max(now_ns - WINDOW_NS, this.about.begin_ns);
      const first = shown === "last" ? end - 1 : Math.min(messages.until(now_ns - WINDOW_NS), end - 1);
      one.sent = Math.max(0, first);
      this.announce(one.channel.topic, from_ns, end - one.sent);
    }
    this.goOn(id, one);
  }

  /** Sends what has come since the last message. */
  private goOn(id: number, one: Subscription): void {
    const { messages } = one;
    if (!messages) return;
    const end = messages.until(this.time.now_ns);
    if (one.shown === "last") one.sent = Math.max(one.sent, end - 1);
    for (; one.sent < end; one.sent++)
      this.message(id, messages.times_ns[one.sent] as number, messages.at(one.sent));
  }

  private showAll(): void {
    for (const [id, one] of this.topics) this.show(id, one);
    this.status();
  }

  private announce(topic: string, from_ns: number, count: number): void {
    const past = { topic, from_s: from_ns / 1e9, count, new: false };
    for (const [id, name] of this.reported) if (name === PAST) this.json(id, past);
  }

  // -- reports

  private report(id: number, name: string): void {
    const report = this.about.reports[name] as object;
    this.json(id, name === STATUS ? { ...report, ...this.statusNow() } : report);
  }

  private statusNow() {
    const { state, now_ns, pace } = this.time;
    return { state, pace, t_s: now_ns / 1e9, real_time_factor: null };
  }

  private status(): void {
    this.statusAt_ms = performance.now();
    for (const [id, name] of this.reported) if (name === STATUS) this.report(id, name);
  }

  // -- services

  private async answer(request: ServiceRequest): Promise<void> {
    const name = this.about.services[request.serviceId] ?? "";
    try {
      const service = this.services[name.replace("/cockpit/", "")];
      if (!service) throw new Error(this.about.refusal);
      const found = (await service(request.arguments)) ?? {};
      this.listener.onData(writeResponse(request, found));
    } catch (error) {
      const message = error instanceof Error ? error.message : String(error);
      this.say({ op: "serviceCallFailure", serviceId: request.serviceId, callId: request.callId, message });
    }
  }

  private readonly services: Record<string, (given: Arguments) => object | Promise<object> | undefined> = {
    play: () => this.run(this.about.end_ns),
    run_to: ({ t_s }) => this.run(Number(t_s) * 1e9),
    pause: () => this.moved(() => this.time.pause()),
    pace: ({ factor }) => this.moved(() => Object.assign(this.time, { pace: factor })),
    step: ({ n }) => this.jump(() => this.time.step(Number(n ?? 1))),
    step_back: () => this.jump(() => this.time.step(-1)),
    seek: ({ t_s }) => this.jump(() => this.time.seek(Number(t_s) * 1e9)),
    reset: ({ what }) => {
      if (what !== "all") throw new Error(this.about.refusal);
      return this.jump(() => this.time.seek(this.about.begin_ns));
    },
    messages: ({ topic }) => this.allOf(String(topic)),
    "layout/load": () => this.about.layout,
    "layout/reset": () => this.about.layout,
    "layout/save": () => undefined, // a file keeps nothing
  };

  /** All messages of a topic at once: the page holds them already. */
  private async allOf(topic: string): Promise<Portion> {
    const { begin_ns, end_ns, topics } = this.about;
    const number = topics.findIndex((one) => one.topic === topic);
    if (number < 0) throw new Error(`There is no topic '${topic}'.`);
    const { bytes } = await this.messagesOf(number);
    return {
      from_s: begin_ns / 1e9,
      until_ns: end_ns,
      is_all: true,
      packed: toBase64(new Uint8Array(bytes)),
    };
  }

  private jump(go: () => void): undefined {
    go();
    this.showAll();
  }

  private moved(change: () => void): undefined {
    change();
    this.status();
  }

  private run(until_ns: number): undefined {
    this.moved(() => this.time.runTo(until_ns));
    cancelAnimationFrame(this.frame);
    this.goOnFrom(performance.now());
  }

  private goOnFrom(last_ms: number): void {
    this.frame = requestAnimationFrame((now_ms) => {
      if (this.time.advance(now_ms - last_ms)) {
        for (const [id, one] of this.topics) this.goOn(id, one);
        if (this.time.state !== "running" || now_ms - this.statusAt_ms >= STATUS_MS) this.status();
      }
      if (this.time.state === "running") this.goOnFrom(now_ms);
    });
  }

  // -- sending

  private say(message: object): void {
    this.listener.onData(JSON.stringify(message));
  }

  private json(id: number, value: object): void {
    this.message(id, this.time.now_ns, new TextEncoder().encode(JSON.stringify(value)));
  }

  private message(id: number, t_ns: number, payload: Uint8Array): void {
    this.listener.onData(writeMessage(id, t_ns, payload));
  }
}
