import { beforeEach, expect, test, vi } from "vitest";

const call = vi.hoisted(() => vi.fn());
vi.mock("../wire", () => ({ wire: { call } }));
vi.mock("./run", () => ({ useRun: { getState: () => ({}) } }));

import { command } from "./commands";
import { useNotices } from "./notices";

const texts = () => useNotices.getState().notices.map(({ text }) => text);

beforeEach(() => useNotices.setState({ notices: [] }));

test("what kept a run from going on is said until it goes on", async () => {
  call.mockRejectedValueOnce(new Error("the run has ended"));
  await command("play");
  call.mockResolvedValue({});
  await command("pace");
  expect(texts()).toEqual(["the run has ended"]);
  await command("reset");
  expect(texts()).toEqual([]);
});

test("what was refused otherwise stays until it is closed", async () => {
  call.mockRejectedValueOnce(new Error("no such body"));
  await command("push");
  call.mockResolvedValue({});
  await command("step");
  expect(texts()).toEqual(["no such body"]);
});
