import { select } from "../state/selection";
import type { Footprint } from "./footprint";
import { bodyAt } from "./plan";
import { type MapView, movedBy, toWorld, zoomedAt } from "./projection";

const CLICK_PX = 4;
const KEY_PX = 40;
const KEY_ZOOM = 1.2;

export interface MapSteering {
  view: () => MapView | null;
  setView: (view: MapView) => void;
  footprints: () => readonly Footprint[];
}

/** Lets pointer, wheel and keys move a map and select on it, until the returned function is called. */
export function steerMap(canvas: HTMLCanvasElement, map: MapSteering): () => void {
  const stops = new AbortController();
  const options = { signal: stops.signal };
  let dragged_px = 0;
  const size = () => ({ width: canvas.clientWidth, height: canvas.clientHeight });
  const change = (changed: (view: MapView) => MapView) => {
    const view = map.view();
    if (view) map.setView(changed(view));
  };
  const down = (event: PointerEvent) => {
    canvas.setPointerCapture(event.pointerId);
    dragged_px = 0;
  };
  const move = (event: PointerEvent) => {
    if (!canvas.hasPointerCapture(event.pointerId)) return;
    dragged_px += Math.hypot(event.movementX, event.movementY);
    if (dragged_px > CLICK_PX) change((view) => movedBy(view, event.movementX, event.movementY));
  };
  const up = (event: PointerEvent) => {
    const view = map.view();
    if (!view || dragged_px > CLICK_PX || event.button !== 0) return;
    const body = bodyAt(map.footprints(), toWorld(view, size(), [event.offsetX, event.offsetY]));
    select(body === null ? null : { kind: "body", name: body });
  };
  const wheel = (event: WheelEvent) => {
    event.preventDefault();
    const factor = Math.exp(-event.deltaY * 0.0015);
    change((view) => zoomedAt(view, size(), [event.offsetX, event.offsetY], factor));
  };
  const key = (event: KeyboardEvent) => {
    const changed = changeByKey(event.key, canvas);
    if (!changed || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    change(changed);
  };
  canvas.addEventListener("pointerdown", down, options);
  canvas.addEventListener("pointermove", move, options);
  canvas.addEventListener("pointerup", up, options);
  canvas.addEventListener("wheel", wheel, { ...options, passive: false });
  canvas.addEventListener("keydown", key, options);
  return () => stops.abort();
}

function changeByKey(
  key: string,
  { clientWidth: width, clientHeight: height }: HTMLCanvasElement,
): ((view: MapView) => MapView) | undefined {
  const zoom = (factor: number) => (view: MapView) =>
    zoomedAt(view, { width, height }, [width / 2, height / 2], factor);
  const move = (dx: number, dy: number) => (view: MapView) => movedBy(view, dx * KEY_PX, dy * KEY_PX);
  switch (key) {
    case "ArrowLeft":
      return move(1, 0);
    case "ArrowRight":
      return move(-1, 0);
    case "ArrowUp":
      return move(0, 1);
    case "ArrowDown":
      return move(0, -1);
    case "+":
    case "=":
      return zoom(KEY_ZOOM);
    case "-":
      return zoom(1 / KEY_ZOOM);
    default:
      return undefined;
  }
}
