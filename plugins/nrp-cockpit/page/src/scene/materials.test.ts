import { expect, it } from "vitest";
import { Materials } from "./materials";

const plain = (r: number, b: number, a: number) => ({ color: { r, g: 0, b, a }, mesh: null });
const red = plain(1, 0, 1);
const glass = plain(0, 1, 0.3);

it("equal colours share one material", () => {
  const materials = new Materials();
  expect(materials.of({ ...red })).toBe(materials.of(red));
  expect(materials.of(glass)).not.toBe(materials.of(red));
});

it("only what is not opaque is drawn as transparent", () => {
  const materials = new Materials();
  expect(materials.of(red).transparent).toBe(false);
  expect(materials.of(glass)).toMatchObject({ transparent: true, opacity: 0.3 });
});

it("a colour that nothing has any more is freed", () => {
  const materials = new Materials();
  const [kept, freed] = [materials.of(red), materials.of(glass)];
  let disposed = 0;
  freed.addEventListener("dispose", () => disposed++);
  materials.keepOnly(new Set([kept]));
  expect(disposed).toBe(1);
  expect(materials.of(red)).toBe(kept);
  expect(materials.of(glass)).not.toBe(freed);
});
