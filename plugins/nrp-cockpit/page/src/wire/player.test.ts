import { expect, it } from "vitest";
import { readBinary, textOf, writeServiceRequest } from "./frames";
import { fromBase64, Messages } from "./messages";
import { Player } from "./player";
import type { About } from "./recording";

const S = 1e9;

/** Messages of one byte, at these times. */
function messages(...times_s: number[]): Messages {
  const count = times_s.length;
  const bytes = new ArrayBuffer(8 + 13 * count);
  new DataView(bytes).setUint32(0, count, true);
  new Float64Array(bytes, 8, count).set(times_s.map((t_s) => t_s * S));
  new Uint32Array(bytes, 8 + 8 * count, count).fill(1);
  new Uint8Array(bytes, 8 + 12 * count).set([...times_s.keys()]);
  return new Messages(bytes);
}

const topic = (name: string, shown: "last" | "changes" | "seconds") => ({
  topic: name,
  schemaName: "",
  schema: "",
  shown,
});

const about: About = {
  begin_ns: 0,
  end_ns: 10 * S,
  timestep_ns: 0.02 * S,
  opens_ns: 0,
  topics: [topic("/scene", "changes"), topic("/camera", "last"), topic("/spikes", "seconds")],
  reports: { status: { state: "", t_s: -1 } },
  layout: { layout: 1 },
  services: ["/cockpit/seek", "/cockpit/push", "/cockpit/layout/load", "/cockpit/messages"],
  refusal: "a recording cannot be changed",
  clear: btoa("c"),
};
const recorded = [messages(0, 3, 5), messages(0, 1, 2, 3), messages(1, 2, 3, 6, 7)];
const [SCENE, CAMERA, SPIKES, STATUS, PAST] = [0, 1, 2, 3, 4];
const CLEAR = "c".charCodeAt(0);

const soon = () => new Promise((resolve) => setTimeout(resolve));

/** A page that subscribed to a channel and seeks; it notes the first byte of each message, or its JSON. */
class Page {
  readonly heard: unknown[] = [];
  readonly texts: string[] = [];
  readonly answers: string[] = [];
  constructor(private readonly opens_s = 0) {}
  private readonly player = new Player(
    { onLink: () => undefined, onData: (data) => this.take(data) },
    {
      about: async () => ({ ...about, opens_ns: this.opens_s * S }),
      messages: async (number) => recorded[number] as Messages,
    },
  );

  async subscribe(...channels: (number | undefined)[]): Promise<this> {
    this.player.open();
    await soon();
    const subscriptions = channels.map((channelId) => ({ id: 100 + (channelId ?? 0), channelId }));
    this.player.send(JSON.stringify({ op: "subscribe", subscriptions }));
    await soon();
    return this;
  }

  async call(service: number, request: object): Promise<unknown[]> {
    this.heard.length = 0;
    this.player.send(writeServiceRequest(service, 1, request));
    await soon();
    return this.heard;
  }

  seek(t_s: number): Promise<unknown[]> {
    return this.call(0, { t_s });
  }

  private take(data: string | ArrayBuffer): void {
    if (typeof data === "string") {
      this.texts.push(data);
      return;
    }
    const message = readBinary(data);
    if (message?.op === "response") this.answers.push(textOf(message.data));
    if (message?.op !== "message") return;
    const isJson = message.subscriptionId >= 103;
    this.heard.push(isJson ? JSON.parse(textOf(message.data)) : message.data.getUint8(0));
  }
}

it("sends the changes of a scene up to now, and all again after it was cleared", async () => {
  const page = await new Page().subscribe(SCENE);
  expect(page.heard).toEqual([0]);
  expect(await page.seek(4)).toEqual([1]);
  expect(await page.seek(4.5)).toEqual([]);
  expect(await page.seek(2)).toEqual([CLEAR, 0]);
  expect(await page.seek(9)).toEqual([1, 2]);
});

it("sends the last image, and the last seconds of what is plotted", async () => {
  expect(await (await new Page().subscribe(CAMERA)).seek(2.5)).toEqual([2]);
  expect(await (await new Page().subscribe(SPIKES)).seek(6.5)).toEqual([2, 3]);
});

it("announces what follows", async () => {
  const page = await new Page().subscribe(PAST, SPIKES);
  expect(page.heard).toEqual([{ topic: "/spikes", from_s: 0, count: 0, new: false }]);
  expect((await page.seek(6.5))[0]).toEqual({ topic: "/spikes", from_s: 2.5, count: 2, new: false });
});

it("reports its time, and refuses what changes a run", async () => {
  const page = await new Page().subscribe(STATUS);
  expect(await page.seek(10)).toMatchObject([{ state: "finished", t_s: 10 }]);
  await page.call(1, {});
  expect(JSON.parse(page.texts.at(-1) ?? "")).toMatchObject({
    op: "serviceCallFailure",
    message: about.refusal,
  });
  await page.call(2, {});
  expect(page.answers.at(-1)).toBe('{"layout":1}');
});

it("gives all messages of a topic, whatever the time is", async () => {
  const page = await new Page().subscribe(STATUS);
  await page.call(3, { topic: "/spikes", after_ns: -1 });
  await soon();
  const { packed, ...portion } = JSON.parse(page.answers.at(-1) ?? "");
  expect(portion).toEqual({ from_s: 0, until_ns: 10 * S, is_all: true });
  const { buffer } = fromBase64(packed);
  expect([...new Messages(buffer).times_ns]).toEqual([1, 2, 3, 6, 7].map((t_s) => t_s * S));
});

it("begins at the moment with which the file opens", async () => {
  const page = await new Page(4).subscribe(STATUS);
  expect(page.heard).toEqual([{ state: "paused", t_s: 4, pace: 1, real_time_factor: null }]);
});
