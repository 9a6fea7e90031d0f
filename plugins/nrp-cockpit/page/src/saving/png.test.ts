import { expect, test } from "vitest";
import { withResolution } from "./png";

test("the resolution stands behind the first chunk, with the checksum of the standard", async () => {
  const png = new Blob([new Uint8Array(40)]);
  const bytes = [...new Uint8Array(await withResolution(png, 300).arrayBuffer())];
  expect(bytes).toHaveLength(61);
  // by zlib: crc32(b"pHYs" + struct.pack(">IIB", 11811, 11811, 1))
  expect(bytes.slice(33, 54)).toEqual([
    0, 0, 0, 9, 112, 72, 89, 115, 0, 0, 46, 35, 0, 0, 46, 35, 1, 120, 165, 63, 118,
  ]);
});
