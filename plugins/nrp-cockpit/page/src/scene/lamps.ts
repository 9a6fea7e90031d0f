import { Color, type Light as Lamp, PointLight, SpotLight } from "three";
import type { Light } from "../state/types";

/** Each costs time for every pixel. */
const MOST_LAMPS = 4;
/** At this distance (m) a lamp is as bright as the room's file says. */
const TYPICAL_M = 2;
/** What three.js calls the light of a lamp that shows a colour as it is. */
const FULL = Math.PI;

/** The lamps of a room: its point and spot lights. */
export const lampsOf = (lights: readonly Light[]): Lamp[] =>
  lights
    .filter(({ kind }) => kind !== "directional")
    .slice(0, MOST_LAMPS)
    .map(lampOf);

/** How bright a lamp is, and with which power of the distance that falls: as its largest term does. */
export function brightness({ attenuation: [constant, linear, quadratic] }: Light): {
  intensity: number;
  decay: number;
} {
  const terms = [constant, linear * TYPICAL_M, quadratic * TYPICAL_M ** 2];
  const decay = terms.indexOf(Math.max(...terms));
  const sum = terms.reduce((total, term) => total + term, 0);
  return { intensity: (FULL * TYPICAL_M ** decay) / Math.max(sum, 0.05), decay };
}

function lampOf(light: Light): Lamp {
  const { intensity, decay } = brightness(light);
  const color = new Color(...light.color);
  const range_m = light.range_m ?? 0; // 0: without an end
  if (light.kind === "point") {
    const lamp = new PointLight(color, intensity, range_m, decay);
    lamp.position.set(...light.position);
    return lamp;
  }
  const lamp = new SpotLight(
    color,
    intensity,
    range_m,
    Math.min(light.cone_rad / 2, Math.PI / 2),
    0.3,
    decay,
  );
  lamp.position.set(...light.position);
  lamp.add(lamp.target); // so its place is counted from the lamp
  lamp.target.position.set(...light.direction);
  return lamp;
}
