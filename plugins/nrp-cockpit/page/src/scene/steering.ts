import { push } from "../state/commands";
import { notify } from "../state/notices";
import { blockedBy, missingOf, useRun } from "../state/run";
import { select, useSelection } from "../state/selection";
import { Carry } from "./carry";
import {
  addAt,
  beginToAdd,
  isStatic,
  nudge,
  poseOf,
  poseText,
  put,
  say,
  shiftOf,
  useEditing,
} from "./editing";
import { orbited, panned, zoomed } from "./orbit";
import { newtons, PUSH_S, PushDrag } from "./push";
import type { Viewer } from "./viewer";

const RAD_PER_PX = 0.008;
const CLICK_PX = 4;
const KEY_RAD = 0.08;
const KEY_PAN = 0.06;
const KEY_ZOOM = 1.15;

export interface Steering {
  viewer: Viewer;
  /** Whether a drag turns the view; seen from above, it only moves it. */
  turns: () => boolean;
  /** Says what a drag would do to a body, at a place on the canvas; null: none is dragged now. */
  onDrag: (drag: { text: string; x: number; y: number } | null) => void;
}

/** Lets pointer, wheel and keys move the view, select bodies and push them, until the returned function is called. */
export function steer(canvas: HTMLCanvasElement, steering: Steering): () => void {
  const pointer = new Pointer(canvas, steering);
  const wheel = (event: WheelEvent) => zoomAtPointer(event, steering.viewer);
  const key = (event: KeyboardEvent) => {
    if (pointer.key(event) || byKey(event, steering)) {
      event.preventDefault();
      event.stopPropagation();
    }
  };
  const stops = new AbortController();
  const options = { signal: stops.signal };
  canvas.addEventListener("pointerdown", (event) => pointer.down(event), options);
  canvas.addEventListener("pointermove", (event) => pointer.move(event), options);
  canvas.addEventListener("pointerup", (event) => pointer.up(event), options);
  canvas.addEventListener("pointercancel", () => pointer.cancel(), options);
  canvas.addEventListener("dblclick", () => steering.viewer.fit(), options); // its first click selects
  canvas.addEventListener("wheel", wheel, { ...options, passive: false });
  canvas.addEventListener("keydown", key, options);
  return () => {
    pointer.cancel();
    stops.abort();
  };
}

/** The drags and clicks of one pointer. */
class Pointer {
  private at: { x: number; y: number } | null = null;
  private dragged_px = 0;
  private pushed: PushDrag | null = null;
  private carried: Carry | null = null;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly steering: Steering,
  ) {}

  down(event: PointerEvent): void {
    if (event.button > 2 || this.at) return;
    this.canvas.setPointerCapture(event.pointerId);
    this.at = { x: event.offsetX, y: event.offsetY };
    this.dragged_px = 0;
    if (event.button !== 0) return;
    if (event.altKey) this.take();
    else if (useEditing.getState().isOn) this.carry(event.shiftKey);
  }

  move(event: PointerEvent): void {
    if (!this.at) return;
    const dx = event.offsetX - this.at.x;
    const dy = event.offsetY - this.at.y;
    this.at = { x: event.offsetX, y: event.offsetY };
    this.dragged_px += Math.hypot(dx, dy);
    const { viewer, turns, onDrag } = this.steering;
    if (this.pushed) {
      const amount_n = this.pushed.move(event.offsetX, event.offsetY);
      onDrag({ text: `${newtons(amount_n)} for ${PUSH_S} s`, ...this.at });
    } else if (this.carried) {
      this.carried.move(event.offsetX, event.offsetY);
      onDrag({ text: poseText(this.carried.pose), ...this.at });
    } else if (turns() && event.buttons === 1 && !event.shiftKey) {
      viewer.view = orbited(viewer.view, -dx * RAD_PER_PX, dy * RAD_PER_PX);
    } else viewer.view = panned(viewer.view, -dx / this.canvas.clientHeight, dy / this.canvas.clientHeight);
  }

  up(event: PointerEvent): void {
    const { pushed, carried } = this;
    const isDragged = this.dragged_px > CLICK_PX;
    if (pushed && isDragged) void push(pushed.hit.body, pushed.force_n, PUSH_S);
    else if (carried && isDragged) this.drop(carried);
    else if (this.at && !isDragged && event.button === 0) this.click(event);
    this.cancel();
  }

  /** Escape gives up what has begun; Enter adds what is chosen in the middle of the view. */
  key({ key }: KeyboardEvent): boolean {
    if (key === "Enter") return this.add(this.canvas.clientWidth / 2, this.canvas.clientHeight / 2);
    if (key !== "Escape" || !(this.pushed || this.carried || useEditing.getState().adding)) return false;
    this.cancel();
    beginToAdd(null);
    return true;
  }

  cancel(): void {
    this.at = null;
    this.pushed?.end();
    this.carried?.end();
    this.pushed = this.carried = null;
    this.steering.onDrag(null);
  }

  private click(event: PointerEvent): void {
    if (this.add(event.offsetX, event.offsetY)) return;
    const hit = this.steering.viewer.hit(event.offsetX, event.offsetY);
    select(hit && { kind: "body", name: hit.body });
  }

  /** Adds what is chosen at a place on the canvas. */
  private add(atX: number, atY: number): boolean {
    const { adding } = useEditing.getState();
    if (adding === null) return false;
    const { x, y, z } = this.steering.viewer.groundAt(atX, atY);
    void addAt(adding, [x, y, z]);
    return true;
  }

  /** Takes the body under the pointer to carry it; one that never moves must be selected, as walls are everywhere. */
  private carry(turns: boolean): void {
    const { viewer } = this.steering;
    const hit = this.at && useEditing.getState().adding === null && viewer.hit(this.at.x, this.at.y);
    if (!hit || (isStatic(hit.body) && hit.body !== selectedBody())) return;
    const pose = poseOf(hit.body);
    const refused = whyNotMoved();
    if (refused) notify(refused);
    else if (pose && this.at) this.carried = new Carry(viewer, hit, pose, turns, this.at.x);
  }

  private drop({ hit, pose }: Carry): void {
    select({ kind: "body", name: hit.body });
    say(hit.body, pose);
    void put(hit.body, pose);
  }

  private take(): void {
    const hit = this.at && this.steering.viewer.hit(this.at.x, this.at.y);
    if (!hit) return;
    const refused = whyNotPushed(hit.body);
    if (refused) notify(refused);
    else this.pushed = new PushDrag(this.steering.viewer, hit);
  }
}

/** Why bodies cannot be moved now, or undefined. */
export function whyNotMoved(): string | undefined {
  const run = useRun.getState();
  return blockedBy(run) ?? missingOf(run, "place");
}

const selectedBody = (): string | null => {
  const { selected } = useSelection.getState();
  return selected?.kind === "body" ? selected.name : null;
};

/** Why a body cannot be pushed now, or undefined. */
export function whyNotPushed(body: string): string | undefined {
  const { experiment } = useRun.getState();
  const able = experiment?.capabilities.push;
  if (!experiment?.may_steer) return "You can watch this run, but not control it.";
  if (typeof able === "string") return able;
  if (experiment.bodies.find(({ name }) => name === body)?.static)
    return `'${body}' is static: it cannot be pushed.`;
  return undefined;
}

function zoomAtPointer(event: WheelEvent, viewer: Viewer): void {
  event.preventDefault();
  const pixels = event.deltaY * (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 24 : 1);
  const { x, y, z } = viewer.pointAt(event.offsetX, event.offsetY);
  viewer.view = zoomed(viewer.view, Math.exp(pixels * 0.0015), [x, y, z]);
}

const arrows: Record<string, readonly [number, number]> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, 1],
  ArrowDown: [0, -1],
};

function byKey(event: KeyboardEvent, { viewer, turns }: Steering): boolean {
  const { view } = viewer;
  const arrow = arrows[event.key];
  if (event.ctrlKey || event.metaKey || event.altKey) return false;
  if (arrow && moveByKey(event, view.azimuth)) return true;
  if (arrow && (event.shiftKey || !turns()))
    viewer.view = panned(view, arrow[0] * KEY_PAN, arrow[1] * KEY_PAN);
  else if (arrow) viewer.view = orbited(view, arrow[0] * KEY_RAD, arrow[1] * KEY_RAD);
  else if (event.key === "+" || event.key === "=") viewer.view = zoomed(view, 1 / KEY_ZOOM);
  else if (event.key === "-") viewer.view = zoomed(view, KEY_ZOOM);
  else return false;
  return true;
}

/** While bodies are edited, arrows move the selected one instead of the view. */
function moveByKey({ key, shiftKey }: KeyboardEvent, azimuth: number): boolean {
  const body = selectedBody();
  if (!useEditing.getState().isOn || body === null) return false;
  const shift = shiftOf(key, shiftKey, azimuth);
  const refused = whyNotMoved();
  if (refused) notify(refused);
  else if (shift) nudge(body, shift);
  return true;
}
