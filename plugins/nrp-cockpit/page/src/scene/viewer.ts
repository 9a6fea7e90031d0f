import {
  type Box3,
  Color,
  PCFShadowMap,
  PerspectiveCamera,
  Plane,
  Raycaster,
  Scene,
  Vector2,
  Vector3,
  WebGLRenderer,
} from "three";
import { pictureDrawn, waitNoLonger } from "../state/picture";
import { useRun } from "../state/run";
import type { Light, Mount } from "../state/types";
import { REPAINT } from "../ui/picture";
import { scale } from "../world/scale";
import type { Change } from "../world/world";
import { world } from "../world/world";
import { Bodies, type ShapeMesh } from "./bodies";
import { firstView, keepView, type Layer, useChoices } from "./choices";
import { drawingOn } from "./context";
import { isWall, openWalls } from "./dollhouse";
import { Muscles } from "./muscles";
import { beginsAt, eyeOf, FOV_RAD, fitted, imageAxes, nearOf, type Orbit, START } from "./orbit";
import { Outline } from "./outline";
import type { LaserScan } from "./sightLines";
import { Sights } from "./sights";
import { Surroundings } from "./surroundings";
import { type Contacts, Touches } from "./touches";
import { Trails } from "./trails";

/** Gets the size of the image in CSS pixels. */
type DrawnListener = (width: number, height: number) => void;

export interface Hit {
  body: string;
  point: Vector3;
}

/** The largest initial distance of the camera from the robot (m). */
const BEGIN_M = 9;
/** The size (m) of a room, and of a smaller one, whose lines and arrows are drawn as they are. */
const USUAL_ROOM_M = 6;
const SMALLEST_ROOM_M = 0.001;

/** Without a graphics card, poses that change all the time are drawn at most this often (ms): plots need it more. */
const SLOW_MS = 60;

/** Draws the world on a canvas, whenever something in it or the view of it changed. */
export class Viewer {
  readonly camera = new PerspectiveCamera((FOV_RAD * 180) / Math.PI, 1, 0.05, 1000);
  readonly scene = new Scene();
  readonly bodies = new Bodies(() => this.invalidate());
  private readonly muscles = new Muscles();
  private readonly trails = new Trails();
  private readonly sights = new Sights();
  private readonly touches = new Touches();
  private readonly renderer: WebGLRenderer;
  private readonly surroundings: Surroundings;
  private readonly outline = new Outline();
  private readonly size = new Vector2(1, 1);
  private readonly drawn = new Set<DrawnListener>();
  private readonly resizing: ResizeObserver;
  private readonly unfollow: () => void;
  private walls: ShapeMesh[] = [];
  private selected: string | null = null;
  private orbit: Orbit;
  private placed: boolean;
  private frame = 0;
  private timer = 0;
  private drawn_ms = 0;
  /** How long a picture stays at least while bodies move (ms). */
  private readonly pause_ms: number;
  /** Whether the scene has come; before, there is nothing to draw. */
  private known = false;
  private disposed = false;
  private styled = false;

  /** @throws Error if the browser has no WebGL. */
  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly panel: string,
  ) {
    const seen = useChoices.getState().views[panel];
    this.orbit = seen ?? START;
    this.placed = seen !== undefined;
    const { context, fine } = drawingOn(canvas);
    this.renderer = new WebGLRenderer({ canvas, context });
    this.renderer.debug.checkShaderErrors = import.meta.env.DEV; // to ask for errors waits for the compiler
    this.renderer.shadowMap.enabled = fine;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.renderer.shadowMap.autoUpdate = false;
    this.pause_ms = fine ? 0 : SLOW_MS;
    this.renderer.setPixelRatio(fine ? Math.min(2, window.devicePixelRatio) : 1);
    this.surroundings = new Surroundings(fine);
    this.camera.up.set(0, 0, 1);
    this.scene.add(
      this.surroundings.root,
      this.bodies.root,
      this.muscles.root,
      this.trails.root,
      this.sights.root,
      this.touches.root,
    );
    this.resizing = new ResizeObserver(() => this.resize());
    this.resizing.observe(canvas);
    const ratio = this.renderer.getPixelRatio();
    canvas.addEventListener(REPAINT, (event) => {
      this.renderer.setPixelRatio((event as CustomEvent<number | null>).detail ?? ratio);
      this.draw();
    });
    this.unfollow = world.follow((change) => this.changed(change));
    if (world.entities.size > 0) this.changed("scene");
  }

  get view(): Orbit {
    return this.orbit;
  }

  set view(view: Orbit) {
    this.orbit = view;
    this.placed = true;
    keepView(this.panel, view);
    this.invalidate();
  }

  /** Draws soon; several calls before a frame draw once. */
  invalidate(): void {
    if (this.disposed) return;
    this.frame ||= requestAnimationFrame(() => {
      this.frame = 0;
      this.draw();
    });
  }

  /** Draws as soon as the last picture has stood long enough; the last poses are always drawn. */
  private invalidateInTime(): void {
    const left_ms = this.drawn_ms + this.pause_ms - performance.now();
    if (left_ms <= 0) this.invalidate();
    else
      this.timer ||= window.setTimeout(() => {
        this.timer = 0;
        this.invalidate();
      }, left_ms);
  }

  /** Shows the selected body, or else the whole room, from the direction of now. */
  fit(): void {
    this.view =
      (this.selected && this.viewOf(this.selected)) || this.viewOfRoom(this.bodies.standing()) || this.orbit;
  }

  /** The point of the scene at a place on the canvas; beside all bodies, one as far away as the target. */
  pointAt(x: number, y: number): Vector3 {
    const hit = this.hit(x, y);
    if (hit) return hit.point;
    const { clientWidth, clientHeight } = this.canvas;
    const half_m = this.orbit.distance_m * Math.tan(FOV_RAD / 2);
    const { right, up } = imageAxes(this.orbit);
    const toRight = ((2 * x) / clientWidth - 1) * half_m * this.camera.aspect;
    const toTop = (1 - (2 * y) / clientHeight) * half_m;
    return new Vector3(...this.orbit.target)
      .addScaledVector(new Vector3(...right), toRight)
      .addScaledVector(new Vector3(...up), toTop);
  }

  /** What stands at a place on the canvas, or the point there at height 0. */
  groundAt(x: number, y: number): Vector3 {
    const hit = this.hit(x, y);
    const flat = () => this.ray(x, y).ray.intersectPlane(new Plane(new Vector3(0, 0, 1)), new Vector3());
    return hit?.point ?? flat() ?? new Vector3(...this.orbit.target);
  }

  select(body: string | null): void {
    this.selected = body;
    this.outline.around(body === null ? [] : [...this.bodies.of(body)]);
    this.invalidate();
  }

  showLayers(layers: ReadonlySet<Layer>): void {
    this.trails.root.visible = layers.has("trail");
    this.trails.show(world.trails);
    this.sights.show(layers);
    this.touches.root.visible = layers.has("contacts");
    this.invalidate();
  }

  /** Shows where these sensors look. */
  mount(mounts: readonly Mount[]): void {
    this.sights.mount(mounts);
    this.sights.move((frame) => world.frame(frame));
    this.invalidate();
  }

  scan(mount: Mount, scan: LaserScan): void {
    this.sights.scan(mount, scan);
    this.invalidate();
  }

  touch(contacts: Contacts): void {
    this.touches.show(contacts);
    this.invalidate();
  }

  /** Shows the room in its own light. */
  light(lights: readonly Light[]): void {
    this.surroundings.light(lights);
    const room = this.bodies.room();
    if (!room.isEmpty()) this.surroundings.surround(room);
    else this.renderer.compile(this.bodies.typical, this.camera, this.scene); // takes long: begins before they come
    this.renderer.shadowMap.needsUpdate = true;
    this.invalidate();
  }

  /** Calls back after each drawn frame, until the returned function is called. */
  onDrawn(listener: DrawnListener): () => void {
    this.drawn.add(listener);
    return () => this.drawn.delete(listener);
  }

  /** A colour of the theme. */
  color(token: string): Color {
    return new Color(this.token(token));
  }

  /** Takes over the colours of the theme before the next frame; to read them now would lay out the page. */
  style(): void {
    this.styled = false;
    this.invalidate();
  }

  private applyStyle(): void {
    if (this.styled) return;
    this.styled = true;
    this.outline.style(this.color("--accent"), this.size.x, this.size.y);
    this.trails.style(this.color("--d-purple"));
    this.sights.style(this.color("--d-orange"), this.color("--d-sky"));
    this.touches.style(this.color("--d-vermillion"));
    this.surroundings.style(this.color("--line-strong"), Number(this.token("--scene-dim")) || 1);
  }

  /** The ray through a point of the canvas, in CSS pixels from its corner. */
  ray(x: number, y: number): Raycaster {
    const ray = new Raycaster();
    const at = new Vector2((2 * x) / this.size.x - 1, 1 - (2 * y) / this.size.y);
    ray.setFromCamera(at, this.camera);
    return ray;
  }

  /** The nearest body at a point of the canvas. */
  hit(x: number, y: number): Hit | null {
    const seen = [...this.bodies.all()].filter((mesh) => mesh.visible && mesh.parent?.visible);
    const [first] = this.ray(x, y).intersectObjects(seen, false);
    return first ? { body: (first.object as ShapeMesh).entity.body, point: first.point } : null;
  }

  dispose(): void {
    this.disposed = true;
    this.unfollow();
    this.resizing.disconnect();
    cancelAnimationFrame(this.frame);
    window.clearTimeout(this.timer);
    this.outline.dispose();
    this.muscles.dispose();
    this.trails.dispose();
    this.sights.dispose();
    this.touches.dispose();
    this.surroundings.dispose();
    this.bodies.dispose();
    this.renderer.dispose();
    // browsers keep few contexts; a canvas that stays in the page, as in React's strict mode, needs its own again
    if (!this.canvas.isConnected) this.renderer.forceContextLoss();
  }

  private changed(change: Change): void {
    if (change === "scene") this.rebuild();
    this.bodies.move((frame) => world.frame(frame), world.awaited);
    this.muscles.show(world.muscles);
    if (!this.placed) this.begin();
    this.sights.move((frame) => world.frame(frame));
    this.trails.show(world.trails);
    this.renderer.shadowMap.needsUpdate = true;
    if (change === "scene") this.invalidate();
    else this.invalidateInTime();
  }

  private viewOf(body: string): Orbit | null {
    const box = this.bodies.boxOf(this.bodies.of(body));
    return box.isEmpty() ? null : this.viewOfBox(box);
  }

  private viewOfBox(box: Box3): Orbit {
    const { x, y, z } = box.getCenter(new Vector3());
    const radius_m = Math.max(SMALLEST_ROOM_M, box.getSize(new Vector3()).length() / 2);
    return fitted(this.orbit, [x, y, z], radius_m, this.camera.aspect);
  }

  private viewOfRoom(room: Box3): Orbit | null {
    if (room.isEmpty()) return null;
    const { x, y } = room.getCenter(new Vector3());
    const size = room.getSize(new Vector3());
    if (size.z > Math.hypot(size.x, size.y) / 2) return this.viewOfBox(room);
    const radius_m = Math.max(SMALLEST_ROOM_M, 0.42 * Math.hypot(size.x, size.y));
    // walls may be high, and what counts stands on the ground
    return fitted(this.orbit, [x, y, Math.max(room.min.z, 0)], radius_m, this.camera.aspect);
  }

  /** The first view: of the room, or of the surroundings of the robot as soon as it is known, if the room is large. */
  private begin(): void {
    const view = this.viewOfRoom(this.bodies.room());
    const [first] = useRun.getState().experiment?.robots ?? [];
    if (!view) return;
    const parts = [...this.bodies.of(first ?? "")];
    if (parts.length > 0 && parts.every(({ entity }) => world.knows(entity.frame))) {
      this.bodies.root.updateMatrixWorld();
      const box = this.bodies.boxOf(parts);
      const { x, y, z } = box.getCenter(new Vector3());
      const all_m = this.viewOfBox(this.bodies.standing()).distance_m;
      const distance_m = Math.min(BEGIN_M, beginsAt(box.getSize(new Vector3()).length(), all_m));
      const near = { ...view, target: [x, y, z] as const, distance_m };
      this.view = firstView(view.distance_m > distance_m ? near : view);
    } else if (first === undefined) this.view = firstView(view);
    else this.orbit = view; // not kept: the robot's place comes soon
  }

  private rebuild(): void {
    this.known = true;
    this.bodies.show(world.entities);
    this.bodies.move((frame) => world.frame(frame), world.awaited);
    this.bodies.root.updateMatrixWorld();
    this.select(this.selected);
    this.surround();
    this.renderer.compile(this.scene, this.camera); // all at once; to draw waits for one after the other
  }

  private surround(): void {
    const room = this.bodies.room();
    if (room.isEmpty()) return;
    const { x, y } = room.getSize(new Vector3());
    scale.unit = Math.min(1, Math.max(x, y) / USUAL_ROOM_M);
    this.walls = [...this.bodies.all()].filter((mesh) => isWall(mesh, Math.max(x, y)));
    this.surroundings.surround(room);
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.canvas;
    if (clientWidth === 0 || clientHeight === 0) return;
    this.size.set(clientWidth, clientHeight);
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.aspect = clientWidth / clientHeight;
    this.camera.updateProjectionMatrix();
    this.style();
  }

  private draw(): void {
    if (!this.known) return;
    this.drawn_ms = performance.now();
    this.applyStyle();
    this.camera.position.set(...eyeOf(this.orbit));
    this.camera.lookAt(...this.orbit.target);
    this.camera.near = nearOf(this.orbit);
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
    this.bodies.root.updateMatrixWorld();
    openWalls(this.walls, this.camera.position, new Vector3(...this.orbit.target));
    this.renderer.render(this.scene, this.camera);
    if (this.bodies.root.children.length > 0) pictureDrawn();
    else waitNoLonger();
    for (const listener of this.drawn) listener(this.size.x, this.size.y);
  }

  private token(name: string): string {
    return getComputedStyle(this.canvas).getPropertyValue(name).trim();
  }
}
