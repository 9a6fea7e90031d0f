/** Puts stretches that overlap into different rows, as few as possible; the rows in the order of the stretches. */
export function stack(stretches: readonly { from_s: number; to_s: number }[]): number[] {
  const rows: number[] = new Array(stretches.length).fill(0);
  const ends: number[] = [];
  const order = stretches.map((_, at) => at).sort((a, b) => from(a) - from(b));
  function from(at: number): number {
    return stretches[at]?.from_s ?? 0;
  }
  for (const at of order) {
    const free = ends.findIndex((end_s) => end_s <= from(at) + 1e-9);
    const row = free < 0 ? ends.length : free;
    ends[row] = stretches[at]?.to_s ?? 0;
    rows[at] = row;
  }
  return rows;
}
