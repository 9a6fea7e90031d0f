import { expect, it } from "vitest";
import { Calls } from "./calls";

const answer = (text: string) => new DataView(new TextEncoder().encode(text).buffer);

it("a call that comes before the services waits for them", async () => {
  const sent: Uint8Array[] = [];
  const calls = new Calls((data) => sent.push(data) > 0);
  calls.opened();
  const described = calls.call("/describe", {});
  expect(sent).toHaveLength(0);
  calls.advertised([{ id: 7, name: "/describe" }] as Parameters<Calls["advertised"]>[0]);
  expect(sent).toHaveLength(1);
  calls.answered(1, answer('{"classes": 3}'));
  await expect(described).resolves.toEqual({ classes: 3 });
});

it("a call waits for no lost link", async () => {
  const calls = new Calls(() => true);
  await expect(calls.call("/play", {})).rejects.toThrow("no service '/play'");
  calls.opened();
  const early = calls.call("/play", {});
  calls.lost();
  await expect(early).rejects.toThrow("no service '/play'");
});
