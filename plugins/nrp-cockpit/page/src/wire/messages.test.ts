import { expect, it } from "vitest";
import { Messages } from "./messages";

/** Three messages, at 1, 2 and 2 ms. */
function three(): Messages {
  const bytes = new ArrayBuffer(8 + 3 * 12 + 6);
  new DataView(bytes).setUint32(0, 3, true);
  new Float64Array(bytes, 8, 3).set([1e6, 2e6, 2e6]);
  new Uint32Array(bytes, 32, 3).set([1, 0, 5]);
  new Uint8Array(bytes, 44).set([10, 20, 21, 22, 23, 24]);
  return new Messages(bytes);
}

it("finds messages by their time", () => {
  expect([0, 1e6, 1.5e6, 2e6, 3e6].map((t_ns) => three().until(t_ns))).toEqual([0, 1, 1, 3, 3]);
});

it("gives the bytes of each message", () => {
  const messages = three();
  expect([0, 1, 2].map((number) => [...messages.at(number)])).toEqual([[10], [], [20, 21, 22, 23, 24]]);
});
