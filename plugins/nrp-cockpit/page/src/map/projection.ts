import type { Footprint, Point } from "./footprint";

/** What the map shows: the world's place (m) at the centre of the canvas, and pixels a metre. */
export interface MapView {
  x: number;
  y: number;
  scale: number;
}

export interface Size {
  width: number;
  height: number;
}

const SMALLEST_SCALE = 1;
const LARGEST_SCALE = 1e6;
/** Free pixels around a fitted room. */
const MARGIN_PX = 12;

/** x goes to the right and y to the top, as in the scene from above. */
export const toCanvas = (view: MapView, { width, height }: Size, [x, y]: Point): [number, number] => [
  width / 2 + (x - view.x) * view.scale,
  height / 2 - (y - view.y) * view.scale,
];

export const toWorld = (view: MapView, { width, height }: Size, [px, py]: Point): [number, number] => [
  view.x + (px - width / 2) / view.scale,
  view.y - (py - height / 2) / view.scale,
];

/** The view at `factor` times the scale, with the place under a pixel kept there. */
export function zoomedAt(view: MapView, size: Size, pixel: Point, factor: number): MapView {
  const scale = Math.min(Math.max(view.scale * factor, SMALLEST_SCALE), LARGEST_SCALE);
  const [x, y] = toWorld(view, size, pixel);
  const part = view.scale / scale;
  return { x: x + (view.x - x) * part, y: y + (view.y - y) * part, scale };
}

export const movedBy = (view: MapView, dx_px: number, dy_px: number): MapView => ({
  ...view,
  x: view.x - dx_px / view.scale,
  y: view.y + dy_px / view.scale,
});

/** The view that shows all of some footprints; null if there are none. */
export function fittedTo(footprints: readonly Footprint[], { width, height }: Size): MapView | null {
  const points = footprints.flatMap(({ outline }) => outline);
  if (points.length === 0 || width <= 0 || height <= 0) return null;
  const xs = points.map(([x]) => x);
  const ys = points.map(([, y]) => y);
  const [left, right, low, high] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
  const across = Math.max(1, width - 2 * MARGIN_PX) / Math.max(1e-6, right - left);
  const along = Math.max(1, height - 2 * MARGIN_PX) / Math.max(1e-6, high - low);
  return { x: (left + right) / 2, y: (low + high) / 2, scale: Math.min(across, along) };
}

/** A round length (m: 1, 2 or 5 times a power of ten) that is at most this many pixels long. */
export function barLength(scale: number, longest_px: number): number {
  const longest_m = longest_px / scale;
  const power = 10 ** Math.floor(Math.log10(longest_m));
  return ([5, 2, 1].find((digit) => digit * power <= longest_m) ?? 1) * power;
}

/** A round length in the unit that people use for it. */
export function lengthText(length_m: number): string {
  const [factor, unit] = length_m >= 0.5 ? [1, "m"] : length_m >= 0.01 ? [100, "cm"] : [1000, "mm"];
  return `${Number((length_m * factor).toPrecision(1))} ${unit}`;
}
