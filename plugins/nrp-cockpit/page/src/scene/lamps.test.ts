import { PointLight, type SpotLight, Vector3 } from "three";
import { expect, it } from "vitest";
import type { Light } from "../state/types";
import { brightness, lampsOf } from "./lamps";

const light = (more: Partial<Light>): Light => ({
  kind: "point",
  position: [1, 2, 3],
  direction: [0, 0, -1],
  color: [1, 1, 1],
  casts_shadows: true,
  range_m: null,
  attenuation: [1, 0, 0],
  cone_rad: 1,
  ...more,
});

it.each([
  [[1, 0, 0], 0],
  [[0.1, 1, 0], 1],
  [[0.5, 0.1, 1], 2],
] as const)("a lamp with the attenuation %j falls with the distance to the power of %d", (given, decay) => {
  const [constant, linear, quadratic] = given;
  const lamp = light({ attenuation: [constant, linear, quadratic] });
  const found = brightness(lamp);
  expect(found.decay).toBe(decay);
  const at2m = Math.PI / (constant + 2 * linear + 4 * quadratic);
  expect(found.intensity / 2 ** decay).toBeCloseTo(at2m);
});

it("point and spot lights shine where they are, and the sun is no lamp", () => {
  const [point, spot, ...rest] = lampsOf([
    light({ kind: "directional" }),
    light({}),
    light({ kind: "spot" }),
  ]);
  expect(rest).toEqual([]);
  expect(point).toBeInstanceOf(PointLight);
  expect(point?.position.toArray()).toEqual([1, 2, 3]);
  spot?.updateMatrixWorld();
  expect((spot as SpotLight).target.getWorldPosition(new Vector3()).toArray()).toEqual([1, 2, 2]);
});
