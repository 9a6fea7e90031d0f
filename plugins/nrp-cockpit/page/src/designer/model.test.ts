import { expect, test } from "vitest";
import { functionOf, linesOf, ownerOf, partAt, titleOf } from "./model";
import type { NodeData } from "./types";

const part = (type: string, line: number, fields: NodeData["fields"] = {}): NodeData => ({
  type,
  line,
  text: "",
  fields,
});
const device = part("DeviceChannel", 4, { name: "eye" });
const model = part("Bibi", 2, { transfer_function: [part("Robot2Neuron", 3, { device: [device] })] });
const xml =
  "<?xml?>\n<bibi>\n  <tf>\n    <device>\n      <neurons/>\n    </device>\n    <x/>\n  </tf>\n</bibi>\n";

test("a path leads to its part, or nowhere", () => {
  expect(partAt(model, "transfer_function/0/device/0")).toBe(device);
  expect(partAt(model, "transfer_function/0/device/1")).toBeUndefined();
  expect(partAt(model, "transfer_function/0/device/0/name/0")).toBeUndefined();
  expect(partAt(model, "")).toBe(model);
});

test("a form is closed to what its part is inside of", () => {
  expect(ownerOf("transfer_function/0/device/1")).toBe("transfer_function/0");
  expect(ownerOf("population/2")).toBe("");
});

test("a part belongs to its function, and is called by its name", () => {
  expect(functionOf("transfer_function/0/device/0")).toBe("transfer_function/0");
  expect(functionOf("topic:/husky/camera")).toBe("");
  expect(titleOf(device)).toBe("eye");
  expect(titleOf(part("Scale", 1))).toBe("Scale");
});

test("the lines of a part end with its end tag", () => {
  expect(linesOf(xml, device)).toEqual([4, 6]);
  expect(linesOf(xml, part("x", 7))).toEqual([7, 7]);
  const script = "import sim\n\na = sim.Population(1)\n\nsim.Projection(\n    a,\n    a,\n)\nb = 1\n";
  expect(linesOf(script, part("Population", 3))).toEqual([3, 3]);
  expect(linesOf(script, part("Projection", 5))).toEqual([5, 8]);
});
