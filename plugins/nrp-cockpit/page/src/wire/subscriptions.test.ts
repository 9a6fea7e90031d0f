import { expect, test, vi } from "vitest";
import type { Channel } from "./frames";
import { Subscriptions } from "./subscriptions";

const CAMERA: Channel = { id: 1, topic: "/camera", encoding: "json", schemaName: "x", schema: "{}" };
const message = (value: object) => new DataView(new TextEncoder().encode(JSON.stringify(value)).buffer);

function subscribed() {
  const frames: (() => void)[] = [];
  vi.stubGlobal("requestAnimationFrame", (frame: () => void) => frames.push(frame));
  const heard: [unknown, number][] = [];
  const subscriptions = new Subscriptions(() => {});
  subscriptions.add("/camera", (value, t_s) => heard.push([value, t_s]), "latest", CAMERA);
  const draw = () => {
    for (const frame of frames.splice(0)) frame();
  };
  return { subscriptions, heard, draw };
}

test("a frame gets the last message only", () => {
  const { subscriptions, heard, draw } = subscribed();
  subscriptions.message(1, message({ n: 1 }), 0.1);
  subscriptions.message(1, message({ n: 2 }), 0.2);
  draw();
  expect(heard).toEqual([[{ n: 2 }, 0.2]]);
});

test("a skipped message is not delivered, later ones are", () => {
  const { subscriptions, heard, draw } = subscribed();
  subscriptions.message(1, message({ n: 1 }), 0.1);
  subscriptions.skip("/camera");
  draw();
  expect(heard).toEqual([]);
  subscriptions.message(1, message({ n: 2 }), 0.2);
  draw();
  expect(heard).toEqual([[{ n: 2 }, 0.2]]);
});
