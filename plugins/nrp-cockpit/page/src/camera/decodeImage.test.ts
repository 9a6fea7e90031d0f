import { describe, expect, test } from "vitest";
import { decodeImage, type RawImage } from "./decodeImage";

const image = (encoding: string, width: number, height: number, bytes: number[], step = 0): RawImage => ({
  encoding,
  width,
  height,
  step,
  is_bigendian: 0,
  data: new Uint8Array(bytes),
});

const decoded = (raw: RawImage) => {
  const rgba = new Uint8ClampedArray(raw.width * raw.height * 4);
  const range = decodeImage(raw, rgba);
  return { range, rgba: [...rgba] };
};

describe("colours", () => {
  test.each([
    ["rgb8", [10, 20, 30], [10, 20, 30, 255]],
    ["bgr8", [10, 20, 30], [30, 20, 10, 255]],
    ["rgba8", [10, 20, 30, 40], [10, 20, 30, 40]],
    ["bgra8", [10, 20, 30, 40], [30, 20, 10, 40]],
    ["mono8", [77], [77, 77, 77, 255]],
  ])("of %s come out as rgba", (encoding, bytes, rgba) => {
    expect(decoded(image(encoding, 1, 1, bytes)).rgba).toEqual(rgba);
  });

  test("skip the bytes that fill up a row", () => {
    const { rgba } = decoded(image("mono8", 2, 2, [1, 2, 99, 99, 3, 4, 99, 99], 4));
    expect(rgba.filter((_, at) => at % 4 === 0)).toEqual([1, 2, 3, 4]);
  });
});

describe("depths", () => {
  test("are light when near, dark when far, and black when there are none", () => {
    const bytes = [...new Uint8Array(new Float32Array([1, 3, 5, Number.POSITIVE_INFINITY]).buffer)];
    const { range, rgba } = decoded(image("32FC1", 2, 2, bytes));
    expect(range).toEqual([1, 5]);
    expect([rgba[0], rgba[8], rgba[12], rgba[15]]).toEqual([255, 40, 0, 255]);
    expect(rgba[4]).toBeGreaterThan(40);
  });

  test("of an image whose data begin inside a message are read all the same", () => {
    const message = new Uint8Array(9);
    message.set(new Uint8Array(new Float32Array([2]).buffer), 5);
    const raw = { ...image("32FC1", 1, 1, []), data: message.subarray(5) };
    expect(decoded(raw).range).toEqual([2, 2]);
  });

  test("in millimetres come out in metres", () => {
    expect(decoded(image("16UC1", 2, 1, [0xe8, 0x03, 0, 0])).range).toEqual([1, 1]);
  });
});

test("an image that cannot be drawn says why", () => {
  expect(() => decoded(image("yuv422", 1, 1, [0, 0]))).toThrow(
    "The encoding 'yuv422' is not supported; supported: rgb8, bgr8",
  );
  expect(() => decoded(image("rgb8", 2, 2, [0, 0, 0]))).toThrow("2 by 2 pixels has only 3 bytes");
});
