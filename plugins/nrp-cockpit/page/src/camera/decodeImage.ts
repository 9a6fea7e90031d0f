/** sensor_msgs/Image, as far as a picture needs it. */
export interface RawImage {
  height: number;
  width: number;
  encoding: string;
  is_bigendian: number | boolean;
  /** Bytes a row; at least the width times the bytes a pixel. */
  step: number;
  data: Uint8Array;
}

/** The bytes a pixel, and where red, green, blue and alpha are among them (alpha -1: opaque). */
const COLOURS: Record<string, { bytes: number; places: readonly [number, number, number, number] }> = {
  rgb8: { bytes: 3, places: [0, 1, 2, -1] },
  bgr8: { bytes: 3, places: [2, 1, 0, -1] },
  rgba8: { bytes: 4, places: [0, 1, 2, 3] },
  bgra8: { bytes: 4, places: [2, 1, 0, 3] },
  mono8: { bytes: 1, places: [0, 0, 0, -1] },
  "8UC1": { bytes: 1, places: [0, 0, 0, -1] },
  "8UC3": { bytes: 3, places: [2, 1, 0, -1] },
};

/** How to read one pixel of a depth image, in metres. */
const DEPTHS: Record<
  string,
  { bytes: number; read: (view: DataView, at: number, little: boolean) => number }
> = {
  "32FC1": { bytes: 4, read: (view, at, little) => view.getFloat32(at, little) },
  "16UC1": { bytes: 2, read: (view, at, little) => view.getUint16(at, little) / 1000 || Number.NaN },
};

/** What a picture shows beside its colours: the nearest and the farthest depth. */
export type Range = readonly [near_m: number, far_m: number] | null;

/**
 * Writes a raw image as rgba, four bytes a pixel, and returns the range of its depths if it has any. Near is light,
 * far dark, and what has no depth is black. Throws when the encoding is unknown or the image lacks bytes.
 */
export function decodeImage(image: RawImage, rgba: Uint8ClampedArray): Range {
  const colour = COLOURS[image.encoding];
  const depth = DEPTHS[image.encoding];
  const bytes = colour?.bytes ?? depth?.bytes;
  if (bytes === undefined)
    throw new Error(
      `The encoding '${image.encoding}' is not supported; supported: ${Object.keys({ ...COLOURS, ...DEPTHS }).join(", ")}.`,
    );
  const step = image.step || image.width * bytes;
  if (step < image.width * bytes || image.data.length < step * (image.height - 1) + image.width * bytes)
    throw new Error(
      `The image of ${image.width} by ${image.height} pixels has only ${image.data.length} bytes.`,
    );
  if (depth) return decodeDepth(image, step, depth.read, depth.bytes, rgba);
  if (colour) decodeColour(image, step, colour, rgba);
  return null;
}

function decodeColour(
  { width, height, data }: RawImage,
  step: number,
  { bytes, places }: { bytes: number; places: readonly [number, number, number, number] },
  rgba: Uint8ClampedArray,
): void {
  const [red, green, blue, alpha] = places;
  let to = 0;
  for (let row = 0; row < height; row++) {
    for (let from = row * step, end = from + width * bytes; from < end; from += bytes) {
      rgba[to++] = data[from + red] as number;
      rgba[to++] = data[from + green] as number;
      rgba[to++] = data[from + blue] as number;
      rgba[to++] = alpha < 0 ? 255 : (data[from + alpha] as number);
    }
  }
}

function decodeDepth(
  { width, height, data, is_bigendian }: RawImage,
  step: number,
  read: (view: DataView, at: number, little: boolean) => number,
  bytes: number,
  rgba: Uint8ClampedArray,
): Range {
  const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
  const little = !is_bigendian;
  const depths = new Float32Array(width * height);
  let near = Number.POSITIVE_INFINITY;
  let far = Number.NEGATIVE_INFINITY;
  for (let at = 0; at < depths.length; at++) {
    const depth = read(view, Math.floor(at / width) * step + (at % width) * bytes, little);
    depths[at] = depth;
    if (!Number.isFinite(depth)) continue;
    near = Math.min(near, depth);
    far = Math.max(far, depth);
  }
  const scale = far > near ? 215 / (far - near) : 0;
  depths.forEach((depth, at) => {
    rgba.fill(Number.isFinite(depth) ? 255 - (depth - near) * scale : 0, at * 4, at * 4 + 3);
    rgba[at * 4 + 3] = 255;
  });
  return far >= near ? [near, far] : null;
}
