import { type Orbit, orbited, panned, zoomed } from "../../scene/orbit";

const RAD_PER_PX = 0.008;
const CLICK_PX = 4;
const KEY_RAD = 0.08;
const KEY_ZOOM = 1.15;

/** What is steered. */
interface View {
  view: Orbit;
  fit: () => void;
}

const arrows: Record<string, readonly [number, number]> = {
  ArrowLeft: [-KEY_RAD, 0],
  ArrowRight: [KEY_RAD, 0],
  ArrowUp: [0, KEY_RAD],
  ArrowDown: [0, -KEY_RAD],
};

/** Lets pointer, wheel and keys turn, move and zoom a view, until the returned function is called. */
export function steer(
  canvas: HTMLCanvasElement,
  seen: View,
  onClick: (x: number, y: number) => void,
): () => void {
  const stops = new AbortController();
  const options = { signal: stops.signal };
  let [dragged_px, isDown] = [0, false];
  canvas.addEventListener(
    "pointerdown",
    (event) => {
      canvas.setPointerCapture(event.pointerId);
      [dragged_px, isDown] = [0, true];
    },
    options,
  );
  canvas.addEventListener(
    "pointermove",
    ({ movementX: dx, movementY: dy, shiftKey, buttons }) => {
      if (!isDown) return;
      dragged_px += Math.hypot(dx, dy);
      if (buttons === 1 && !shiftKey) seen.view = orbited(seen.view, -dx * RAD_PER_PX, dy * RAD_PER_PX);
      else seen.view = panned(seen.view, -dx / canvas.clientHeight, dy / canvas.clientHeight);
    },
    options,
  );
  canvas.addEventListener(
    "pointerup",
    ({ offsetX, offsetY }) => {
      if (isDown && dragged_px < CLICK_PX) onClick(offsetX, offsetY);
      isDown = false;
    },
    options,
  );
  canvas.addEventListener("dblclick", () => seen.fit(), options);
  const wheel = (event: WheelEvent) => {
    event.preventDefault();
    seen.view = zoomed(seen.view, Math.exp(event.deltaY * 0.0015));
  };
  canvas.addEventListener("wheel", wheel, { ...options, passive: false });
  const key = (event: KeyboardEvent) => {
    const arrow = arrows[event.key];
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (arrow) seen.view = orbited(seen.view, ...arrow);
    else if (event.key === "+" || event.key === "=") seen.view = zoomed(seen.view, 1 / KEY_ZOOM);
    else if (event.key === "-") seen.view = zoomed(seen.view, KEY_ZOOM);
    else return;
    event.preventDefault();
    event.stopPropagation();
  };
  canvas.addEventListener("keydown", key, options);
  return () => stops.abort();
}
