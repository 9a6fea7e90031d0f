/** Where the cells of a population are, as `x y z x y z ...` in um. */
export function placesIn(base64: string): Float32Array {
  const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
  return new Float32Array(bytes.buffer);
}

/** The middle of all places, and the radius of a ball around it that holds all of them. */
export function ballAround(all: readonly Float32Array[]): {
  middle: [number, number, number];
  radius: number;
} {
  const low = [1, 1, 1].map(() => Number.POSITIVE_INFINITY);
  const high = low.map((one) => -one);
  for (const places of all)
    places.forEach((value, at) => {
      const axis = at % 3;
      low[axis] = Math.min(low[axis] as number, value);
      high[axis] = Math.max(high[axis] as number, value);
    });
  const middle = low.map((one, axis) => (one + (high[axis] as number)) / 2) as [number, number, number];
  const radius = Math.hypot(...low.map((one, axis) => ((high[axis] as number) - one) / 2));
  return { middle, radius: Number.isFinite(radius) && radius > 0 ? radius : 1 };
}

/** Places around the middle, so that all lie in a ball of radius 1. */
export function inUnitBall(
  places: Float32Array,
  { middle, radius }: ReturnType<typeof ballAround>,
): Float32Array<ArrayBuffer> {
  return Float32Array.from(places, (value, at) => (value - (middle[at % 3] as number)) / radius);
}

/** The numbers below a count in an order of which every beginning is spread over all of them. */
export function spread(count: number): Uint32Array {
  const areCoprime = (a: number, b: number): boolean => (b === 0 ? a === 1 : areCoprime(b, a % b));
  let stride = Math.max(1, Math.round(count * 0.618));
  while (!areCoprime(count, stride)) stride++;
  return new Uint32Array(count).map((_, at) => (at * stride) % count);
}
