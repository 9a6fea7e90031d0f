import {
  BufferAttribute,
  BufferGeometry,
  Color,
  PerspectiveCamera,
  Points,
  Scene,
  ShaderMaterial,
  Vector3,
  WebGLRenderer,
} from "three";
import { spikesOf } from "../../plots/spikeStore";
import { drawingOn } from "../../scene/context";
import { eyeOf, FOV_RAD, fitted, nearOf, type Orbit, START } from "../../scene/orbit";
import { REPAINT } from "../../ui/picture";
import { Rarely } from "../../ui/rarely";
import { Fired } from "./fired";
import { ballAround, inUnitBall, spread } from "./places";

/** The cells of a population in space. */
export interface Placed {
  label: string;
  /** `x y z x y z ...` in um. */
  places: Float32Array;
  /** The colours of the cells, as tokens of the theme. */
  colours: readonly string[];
}

const VERTEX = `
  attribute float fired_s;
  uniform float now_s;
  uniform float size_px;
  varying float light;
  varying vec3 own;
  attribute vec3 ink;
  void main() {
    float age_s = now_s - fired_s;
    light = age_s < -0.001 ? 0.0 : exp(-max(age_s, 0.0) / 0.1);
    own = ink;
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
    gl_PointSize = size_px * (1.0 + 2.0 * light);
  }`;

const FRAGMENT = `
  uniform vec3 silent;
  varying float light;
  varying vec3 own;
  void main() {
    gl_FragColor = vec4(mix(silent, own, min(1.0, light * 1.5)), 1.0);
    #include <colorspace_fragment>
  }`;

/** Without a graphics card a picture stands at least this long (ms). */
const SLOW_MS = 60;

/** So many cells are drawn without a graphics card while the picture turns, and all as soon as it stands (ms). */
const MOST_TURNING = 35_000;
const STANDS_MS = 300;

/** Draws cells as points that shine when they fire, whenever something changed. */
export class Cloud {
  private readonly renderer: WebGLRenderer;
  private readonly camera = new PerspectiveCamera((FOV_RAD * 180) / Math.PI, 1, 0.01, 100);
  private readonly scene = new Scene();
  private readonly material: ShaderMaterial;
  private readonly parts: { placed: Placed; fired: Fired; points: Points<BufferGeometry, ShaderMaterial> }[];
  private readonly resizing: ResizeObserver;
  private readonly rarely: Rarely;
  private readonly fine: boolean;
  private frame = 0;
  private turning: ReturnType<typeof setTimeout> | undefined;
  private orbit: Orbit = START;

  /** @throws Error if the browser has no WebGL. */
  constructor(
    private readonly canvas: HTMLCanvasElement,
    all: readonly Placed[],
    private readonly now_s: () => number,
  ) {
    const { context, fine } = drawingOn(canvas);
    this.fine = fine;
    this.renderer = new WebGLRenderer({ canvas, context });
    this.renderer.setPixelRatio(fine ? Math.min(2, window.devicePixelRatio) : 1);
    this.rarely = new Rarely(() => this.invalidate(), fine ? 0 : SLOW_MS);
    this.material = new ShaderMaterial({
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      uniforms: { now_s: { value: 0 }, size_px: { value: 1 }, silent: { value: new Color() } },
    });
    const ball = ballAround(all.map(({ places }) => places));
    this.parts = all.map((placed) => {
      const geometry = new BufferGeometry();
      const fired = new Fired(spikesOf(placed.label), placed.places.length / 3);
      geometry.setAttribute("position", new BufferAttribute(inUnitBall(placed.places, ball), 3));
      geometry.setAttribute("fired_s", new BufferAttribute(fired.times_s, 1));
      if (!fine) geometry.setIndex(new BufferAttribute(spread(fired.times_s.length), 1));
      return { placed, fired, points: new Points(geometry, this.material) };
    });
    this.scene.add(...this.parts.map(({ points }) => points));
    this.camera.up.set(0, 0, 1);
    this.style();
    canvas.addEventListener(REPAINT, () => this.draw());
    this.resizing = new ResizeObserver(() => this.resize());
    this.resizing.observe(canvas);
  }

  get view(): Orbit {
    return this.orbit;
  }

  set view(view: Orbit) {
    this.orbit = view;
    this.invalidate();
    if (this.fine) return;
    clearTimeout(this.turning);
    this.turning = setTimeout(() => {
      this.turning = undefined;
      this.invalidate();
    }, STANDS_MS);
  }

  /** Shows all cells from the direction of now. */
  fit(): void {
    this.view = fitted(this.orbit, [0, 0, 0], FILLED, this.camera.aspect);
  }

  /** Draws soon, because time or spikes changed. */
  moved(): void {
    this.rarely.ask();
  }

  /** Takes over the colours of the theme. */
  style(): void {
    const tokens = getComputedStyle(this.canvas);
    const colour = (token: string) => new Color(tokens.getPropertyValue(token).trim());
    (this.material.uniforms.silent as { value: Color }).value = colour("--line-strong");
    for (const { placed, points } of this.parts) {
      const known = new Map([...new Set(placed.colours)].map((token) => [token, colour(token)] as const));
      const inks = new Float32Array(placed.places.length);
      placed.colours.forEach((token, cell) => {
        known.get(token)?.toArray(inks, 3 * cell);
      });
      points.geometry.setAttribute("ink", new BufferAttribute(inks, 3));
    }
    this.invalidate();
  }

  /** The cell next to a place on the canvas, in CSS pixels; null: there is none near it. */
  cellAt(x: number, y: number): { population: string; index: number } | null {
    const { clientWidth, clientHeight } = this.canvas;
    const at = new Vector3();
    let [found, nearest] = [null as { population: string; index: number } | null, NEAR_PX ** 2];
    for (const { placed, points } of this.parts) {
      const positions = points.geometry.getAttribute("position");
      for (let index = 0; index < positions.count; index++) {
        at.fromBufferAttribute(positions as BufferAttribute, index).project(this.camera);
        const [dx, dy] = [((at.x + 1) * clientWidth) / 2 - x, ((1 - at.y) * clientHeight) / 2 - y];
        const far = dx * dx + dy * dy + at.z * 1e-3; // of two at the same place the one in front
        if (at.z < 1 && far < nearest) [found, nearest] = [{ population: placed.label, index }, far];
      }
    }
    return found;
  }

  dispose(): void {
    this.resizing.disconnect();
    this.rarely.stop();
    cancelAnimationFrame(this.frame);
    clearTimeout(this.turning);
    for (const { points } of this.parts) points.geometry.dispose();
    this.material.dispose();
    this.renderer.dispose();
    if (!this.canvas.isConnected) this.renderer.forceContextLoss();
  }

  private invalidate(): void {
    this.frame ||= requestAnimationFrame(() => {
      this.frame = 0;
      this.draw();
    });
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.canvas;
    if (clientWidth === 0 || clientHeight === 0) return;
    this.renderer.setSize(clientWidth, clientHeight, false);
    const first = this.orbit === START;
    this.camera.aspect = clientWidth / clientHeight;
    if (first) this.fit();
    this.invalidate();
  }

  private draw(): void {
    const { camera, material, canvas } = this;
    const share = this.turning === undefined ? 1 : Math.min(1, MOST_TURNING / cellsOf(this.parts));
    for (const { fired, points } of this.parts) {
      if (fired.update()) points.geometry.getAttribute("fired_s").needsUpdate = true;
      points.geometry.setDrawRange(0, Math.ceil(share * fired.times_s.length));
    }
    (material.uniforms.now_s as { value: number }).value = this.now_s();
    const ratio = this.renderer.getPixelRatio();
    (material.uniforms.size_px as { value: number }).value = ratio * sizeOf(this.parts, canvas.clientHeight);
    camera.position.set(...eyeOf(this.orbit));
    camera.lookAt(...this.orbit.target);
    camera.near = nearOf(this.orbit);
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
    this.renderer.render(this.scene, camera);
  }
}

const NEAR_PX = 8;
/** The radius of what fills the picture: few cells are in the corners of their box. */
const FILLED = 0.75;

/** The size of a silent cell: many are drawn as single pixels. */
const sizeOf = (parts: readonly { placed: Placed }[], height: number): number =>
  Math.min(8, Math.max(1, height / (4 * Math.cbrt(cellsOf(parts)))));

const cellsOf = (parts: readonly { placed: Placed }[]): number =>
  Math.max(
    1,
    parts.reduce((sum, { placed }) => sum + placed.places.length / 3, 0),
  );
