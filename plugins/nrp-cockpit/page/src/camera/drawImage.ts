import { decodeImage, type Range, type RawImage } from "./decodeImage";

/** sensor_msgs/CompressedImage: a whole file, such as a JPEG. */
interface CompressedImage {
  format: string;
  data: Uint8Array<ArrayBuffer>;
}

export type AnyImage = RawImage | CompressedImage;

/**
 * Draws an image on a canvas of its own size, and returns the range of its depths if it has any; undefined: it was
 * `isLate` by the time at which it was decoded, and is not drawn.
 */
export async function drawImage(
  canvas: HTMLCanvasElement,
  image: AnyImage,
  isLate: () => boolean,
): Promise<Range | undefined> {
  const pen = canvas.getContext("2d");
  if (!pen) throw new Error("The browser cannot draw on a canvas.");
  if ("format" in image) {
    const bitmap = await createImageBitmap(new Blob([image.data]));
    const late = isLate();
    if (!late) {
      resize(canvas, bitmap.width, bitmap.height);
      pen.drawImage(bitmap, 0, 0);
    }
    bitmap.close();
    return late ? undefined : null;
  }
  if (image.width === 0 || image.height === 0) throw new Error("The image has no pixels.");
  const pixels = pen.createImageData(image.width, image.height);
  const range = decodeImage(image, pixels.data);
  resize(canvas, image.width, image.height);
  pen.putImageData(pixels, 0, 0);
  return range;
}

function resize(canvas: HTMLCanvasElement, width: number, height: number): void {
  if (canvas.width !== width) canvas.width = width;
  if (canvas.height !== height) canvas.height = height;
}
