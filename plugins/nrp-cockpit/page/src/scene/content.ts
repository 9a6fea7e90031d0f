const names = new WeakMap<Uint8Array, string>();

/** Names a file by its length and a hash (FNV-1a) of its contents. */
export function contentOf(data: Uint8Array): string {
  let name = names.get(data);
  if (name === undefined) {
    let hash = 0x811c9dc5;
    for (const byte of data) hash = Math.imul(hash ^ byte, 0x01000193);
    name = `${data.length}:${hash}`;
    names.set(data, name);
  }
  return name;
}
