import type { Vector } from "../state/types";

export const GLB_TYPE = "model/gltf-binary";

/** A mesh with an image on it, as the platform writes it: one mesh without indices, in metres, x forward and z up. */
export interface TexturedMesh {
  /** Three numbers for each corner of a triangle. */
  positions: Float32Array;
  /** Two numbers for each corner, from the upper left of the image. */
  coordinates: Float32Array;
  image: { data: Uint8Array<ArrayBuffer>; type: string };
  /** By which the image is multiplied, linear red, green and blue. */
  tint: Vector;
  min: Vector;
  max: Vector;
}

interface View {
  byteOffset: number;
  byteLength: number;
}

interface Document {
  accessors: { min: Vector; max: Vector }[];
  bufferViews: View[];
  images: { mimeType: string }[];
  materials: { pbrMetallicRoughness: { baseColorFactor: [number, number, number, number] } }[];
}

const MAGIC = 0x46546c67;
const HEAD_BYTES = 12;
const CHUNK_HEAD_BYTES = 8;

const read = new WeakMap<Uint8Array, TexturedMesh | null>();

/** Reads a file, once; null if it is another one. */
export function texturedMesh(data: Uint8Array): TexturedMesh | null {
  let mesh = read.get(data);
  if (mesh === undefined) {
    mesh = parsed(data);
    read.set(data, mesh);
  }
  return mesh;
}

function parsed(data: Uint8Array): TexturedMesh | null {
  const head = new DataView(data.buffer, data.byteOffset, data.byteLength);
  if (data.byteLength < HEAD_BYTES + CHUNK_HEAD_BYTES || head.getUint32(0, true) !== MAGIC) return null;
  const text = data.subarray(HEAD_BYTES + CHUNK_HEAD_BYTES).subarray(0, head.getUint32(HEAD_BYTES, true));
  const document: Document = JSON.parse(new TextDecoder().decode(text));
  const binary = data.subarray(HEAD_BYTES + CHUNK_HEAD_BYTES + text.byteLength + CHUNK_HEAD_BYTES);
  const [positions, coordinates, image] = document.bufferViews.map(({ byteOffset, byteLength }) =>
    binary.slice(byteOffset, byteOffset + byteLength),
  );
  const [corners] = document.accessors;
  const [material] = document.materials;
  const [file] = document.images;
  if (!positions || !coordinates || !image || !corners || !material || !file) return null;
  const [r, g, b] = material.pbrMetallicRoughness.baseColorFactor;
  return {
    positions: new Float32Array(positions.buffer),
    coordinates: new Float32Array(coordinates.buffer),
    image: { data: image, type: file.mimeType },
    tint: [r, g, b],
    min: corners.min,
    max: corners.max,
  };
}
