import { type PointerEvent, type RefObject, useEffect, useRef } from "react";
import { holdWindow, setWindowLength, useTimeWindow } from "../state/timeWindow";
import { clock } from "./clock";
import { type TimeScale, timeAt } from "./timeAxis";

const DEFAULT_S = 4;
const SHORTEST_S = 0.05;
const LONGEST_S = 60;
/** A pointer that moved no further has clicked. */
const CLICK_PX = 3;

/** Where the pointer is in the window of any plot, from 0 to 1; null: in none. The plots show it together. */
export const crosshair: { share: number | null } = { share: null };

/** Where the common window lies now, over the pixels from `left` to `right`. */
export function scaleNow(left: number, right: number): TimeScale {
  const { length_s, held_s } = useTimeWindow.getState();
  const to_s = held_s ?? Math.max(clock.now_s, length_s);
  return { from_s: to_s - length_s, to_s, left, right };
}

export const pauseOrFollow = (): void =>
  holdWindow(useTimeWindow.getState().held_s === null ? clock.now_s : null);

/** Zooms by a factor; while the window is held, the time under the pointer stays where it is. */
function zoom(scale: TimeScale, x: number, factor: number): void {
  const before_s = scale.to_s - scale.from_s;
  const length_s = Math.min(Math.max(before_s * factor, SHORTEST_S), LONGEST_S);
  const pointed_s = timeAt(scale, x);
  setWindowLength(length_s);
  if (useTimeWindow.getState().held_s !== null)
    holdWindow(pointed_s + ((scale.to_s - pointed_s) * length_s) / before_s);
}

function reset(): void {
  setWindowLength(DEFAULT_S);
  holdWindow(null);
}

interface Drag {
  x: number;
  y: number;
  scale: TimeScale;
  /** Whether it has moved the time, or the lines. */
  moved: boolean;
  movedLines: boolean;
  pullLines: ((dy: number) => void) | undefined;
}

/** Holds the window where the drag has pulled it, and moves the lines along. */
function pull(drag: Drag, x: number, y: number): void {
  drag.moved ||= Math.abs(x - drag.x) > CLICK_PX;
  drag.movedLines ||= Math.abs(y - drag.y) > CLICK_PX;
  const { scale } = drag;
  if (drag.moved) holdWindow(Math.max(0, scale.to_s + timeAt(scale, drag.x) - timeAt(scale, x)));
  if (drag.movedLines) drag.pullLines?.(y - drag.y);
}

/** What a pointer does to lines that stand below each other. */
export interface LineNavigation {
  /** A click at a height, on a line or beside it. */
  press: (y: number, beside: boolean) => void;
  /** The wheel beside the lines, or with Shift. */
  zoom: (y: number, factor: number) => void;
  /** A drag begins, which then moves by some pixels. */
  grab: () => (dy: number) => void;
  reset: () => void;
}

/**
 * The pointer on a plot: the wheel zooms time, a drag moves the window, a double click resets, and the crosshair
 * follows. `scale` holds what was drawn last; `redraw` is asked at every change of the window or of the data; `lines`
 * hears what concerns the other direction.
 */
export function useTimeNavigation(
  canvas: RefObject<HTMLCanvasElement | null>,
  scale: RefObject<TimeScale>,
  redraw: () => void,
  lines?: LineNavigation,
) {
  const drag = useRef<Drag | null>(null);
  useEffect(() => clock.onTick(redraw), [redraw]);
  useEffect(() => useTimeWindow.subscribe(redraw), [redraw]);
  useEffect(() => {
    const element = canvas.current;
    const wheel = (event: WheelEvent) => {
      event.preventDefault();
      const factor = 1.0015 ** (event.deltaY || event.deltaX); // with Shift some browsers turn the wheel
      const { left } = scale.current;
      if (lines && (event.shiftKey || event.offsetX < left)) lines.zoom(event.offsetY, factor);
      else zoom(scale.current, event.offsetX, factor);
    };
    element?.addEventListener("wheel", wheel, { passive: false }); // React's own wheel listeners are passive
    return () => element?.removeEventListener("wheel", wheel);
  }, [canvas, scale, lines]);

  const point = (share: number | null) => {
    crosshair.share = share !== null && share >= 0 && share <= 1 ? share : null;
    clock.tick();
  };
  return {
    onPointerDown: (event: PointerEvent<HTMLCanvasElement>) => {
      event.currentTarget.setPointerCapture(event.pointerId);
      const { offsetX: x, offsetY: y } = event.nativeEvent;
      const [moved, movedLines] = [false, false];
      drag.current = { x, y, scale: { ...scale.current }, moved, movedLines, pullLines: lines?.grab() };
    },
    onPointerMove: ({ nativeEvent: { offsetX, offsetY } }: PointerEvent) => {
      const { left, right } = scale.current;
      if (drag.current) pull(drag.current, offsetX, offsetY);
      else point((offsetX - left) / (right - left));
    },
    onPointerUp: ({ nativeEvent: { offsetX, offsetY } }: PointerEvent) => {
      const hasMoved = drag.current?.moved || drag.current?.movedLines;
      if (drag.current && !hasMoved) lines?.press(offsetY, offsetX < scale.current.left);
      drag.current = null;
    },
    onPointerLeave: () => point(null),
    onDoubleClick: () => {
      reset();
      lines?.reset();
    },
  };
}
