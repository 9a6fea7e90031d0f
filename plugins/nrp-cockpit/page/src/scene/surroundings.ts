import {
  type Box3,
  type Color,
  DirectionalLight,
  GridHelper,
  Group,
  HemisphereLight,
  type Light as Lamp,
  type LineBasicMaterial,
  Vector3,
} from "three";
import type { Light } from "../state/types";
import { lampsOf } from "./lamps";

const SKY_LIGHT = 2.6;
const SUN_LIGHT = 1.5;
/** The share of the light from all sides that remains in a room with lamps of its own. */
const SKY_WITH_LAMPS = 0.5;
/** The direction to the sun of a room that does not say it. */
const SUN = new Vector3(-0.4, -0.5, 1);
const SHADOW_PX = 1024;
/** Below the ground that a scene has, so that the grid shows only where there is none. */
const GRID_Z = -0.004;
/** The grid is made for a room of at least this many of its steps. */
const LEAST_STEPS = 4;

const MOST_STEPS = 200;

/** The step of the grid of a room of this size: 1 m, or the power of ten below a smaller room. */
export const gridStep = (room_m: number): number =>
  room_m >= 1 || room_m <= 0 ? 1 : 10 ** Math.floor(Math.log10(room_m));

/** The light and the ground around the bodies. */
export class Surroundings {
  readonly root = new Group();
  private readonly sky = new HemisphereLight(0xffffff, 0xb5b0a8);
  private readonly sun = new DirectionalLight(0xffffff);
  private lamps: Lamp[] = [];
  private readonly toSun = SUN.clone();
  private dim = 1;
  private grid: GridHelper | null = null;
  private line: Color | null = null;

  constructor(shadows: boolean) {
    this.sun.castShadow = shadows;
    this.sun.shadow.mapSize.setScalar(SHADOW_PX);
    this.sun.shadow.bias = -0.0005;
    this.sun.shadow.normalBias = 0.02;
    this.root.add(this.sky, this.sun, this.sun.target);
  }

  /** Takes over the lights of a room: its first directional one is the sun, and its lamps shine where they are. */
  light(lights: readonly Light[]): void {
    for (const lamp of this.lamps) lamp.removeFromParent().dispose();
    this.lamps = lampsOf(lights);
    for (const lamp of this.lamps) this.root.add(lamp);
    const sun = lights.find(({ kind }) => kind === "directional");
    this.toSun.copy(sun ? new Vector3(...sun.direction).negate() : SUN);
    this.sun.color.setRGB(...(sun?.color ?? [1, 1, 1]));
    this.sun.visible = sun !== undefined || lights.length === 0;
    this.shine();
  }

  /** Lets the light reach, and the grid cover, a room. The grid has steps of 1 m, or of 1 cm on a table of insects. */
  surround(room: Box3): void {
    const centre = room.getCenter(new Vector3());
    const size = room.getSize(new Vector3());
    const step_m = gridStep(Math.max(size.x, size.y));
    const radius = Math.max(step_m, size.length() / 2);
    this.sun.target.position.copy(centre);
    this.sun.position.copy(centre).add(this.toSun.clone().setLength(2 * radius));
    const camera = this.sun.shadow.camera;
    camera.left = camera.bottom = -radius;
    camera.right = camera.top = radius;
    camera.near = 0.1 * step_m;
    camera.far = 4 * radius;
    camera.updateProjectionMatrix();
    this.sun.shadow.normalBias = 0.02 * step_m;
    const half = Math.ceil(1.5 * Math.max(size.x / step_m, size.y / step_m, LEAST_STEPS));
    this.replaceGrid(Math.min(MOST_STEPS, 2 * half), step_m);
  }

  /** `dim` is how bright the theme is, up to 1. */
  style(line: Color, dim: number): void {
    this.dim = dim;
    this.shine();
    this.line = line;
    if (this.grid) (this.grid.material as LineBasicMaterial).color.copy(line);
  }

  dispose(): void {
    for (const lamp of this.lamps) lamp.dispose();
    this.grid?.dispose();
    this.sun.dispose();
    this.sky.dispose();
  }

  private shine(): void {
    this.sky.intensity = SKY_LIGHT * this.dim * (this.lamps.length > 0 ? SKY_WITH_LAMPS : 1);
    this.sun.intensity = SUN_LIGHT * this.dim;
  }

  private replaceGrid(steps: number, step_m: number): void {
    this.grid?.removeFromParent();
    this.grid?.dispose();
    this.grid = new GridHelper(steps * step_m, steps, 0xffffff, 0xffffff);
    this.grid.rotation.x = Math.PI / 2;
    this.grid.position.z = GRID_Z * step_m;
    const material = this.grid.material as LineBasicMaterial;
    material.transparent = true;
    material.opacity = 0.22;
    material.depthWrite = false;
    if (this.line) material.color.copy(this.line);
    this.root.add(this.grid);
  }
}
