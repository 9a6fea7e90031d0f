import {
  type Box3,
  type Color,
  DirectionalLight,
  GridHelper,
  Group,
  HemisphereLight,
  type LineBasicMaterial,
  Vector3,
} from "three";

const SKY_LIGHT = 2.6;
const SUN_LIGHT = 1.5;
const SHADOW_PX = 1024;
/** Below the ground that a scene has, so that the grid shows only where there is none. */
const GRID_Z_M = -0.004;

/** The light and the ground around the bodies. */
export class Surroundings {
  readonly root = new Group();
  private readonly sky = new HemisphereLight(0xffffff, 0xb5b0a8);
  private readonly sun = new DirectionalLight(0xffffff);
  private grid: GridHelper | null = null;
  private line: Color | null = null;

  constructor(shadows: boolean) {
    this.sun.castShadow = shadows;
    this.sun.shadow.mapSize.setScalar(SHADOW_PX);
    this.sun.shadow.bias = -0.0005;
    this.sun.shadow.normalBias = 0.02;
    this.root.add(this.sky, this.sun, this.sun.target);
  }

  /** Lets the light reach, and the grid cover, a room. */
  surround(room: Box3): void {
    const centre = room.getCenter(new Vector3());
    const size = room.getSize(new Vector3());
    const radius = Math.max(1, size.length() / 2);
    this.sun.target.position.copy(centre);
    this.sun.position.copy(centre).add(new Vector3(-0.4, -0.5, 1).setLength(2 * radius));
    const camera = this.sun.shadow.camera;
    camera.left = camera.bottom = -radius;
    camera.right = camera.top = radius;
    camera.near = 0.1;
    camera.far = 4 * radius;
    camera.updateProjectionMatrix();
    this.replaceGrid(Math.min(200, 2 * Math.ceil(1.5 * Math.max(size.x, size.y, 4))));
  }

  /** `dim` is how bright the theme is, up to 1. */
  style(line: Color, dim: number): void {
    this.sky.intensity = SKY_LIGHT * dim;
    this.sun.intensity = SUN_LIGHT * dim;
    this.line = line;
    if (this.grid) (this.grid.material as LineBasicMaterial).color.copy(line);
  }

  dispose(): void {
    this.grid?.dispose();
    this.sun.dispose();
    this.sky.dispose();
  }

  private replaceGrid(size_m: number): void {
    this.grid?.removeFromParent();
    this.grid?.dispose();
    this.grid = new GridHelper(size_m, size_m, 0xffffff, 0xffffff);
    this.grid.rotation.x = Math.PI / 2;
    this.grid.position.z = GRID_Z_M;
    const material = this.grid.material as LineBasicMaterial;
    material.transparent = true;
    material.opacity = 0.22;
    material.depthWrite = false;
    if (this.line) material.color.copy(this.line);
    this.root.add(this.grid);
  }
}
