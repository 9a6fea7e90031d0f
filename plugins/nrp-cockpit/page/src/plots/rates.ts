import { Scroll } from "./scroll";
import { niceStep } from "./timeAxis";
import type { TimeRing } from "./timeRing";

/** The bins for a window of this length: round, about a hundred of them, and none below a millisecond. */
export const binFor = (length_s: number): number => niceStep(Math.max(length_s / 120, 1e-3));

/** Which line of a table counts the spikes of each cell of a population; negative: none. */
export type LineOf = Int32Array;

/** Counts spikes in lines of cells and bins of time; the bins stand still while the window moves over them. */
export class RateTable {
  private readonly counts: Float32Array;
  private readonly scroll: Scroll;

  constructor(
    length_s: number,
    readonly bin_s: number,
    /** The number of cells of each line. */
    readonly sizes: readonly number[],
  ) {
    this.scroll = new Scroll(Math.ceil(length_s / bin_s + 1e-6) + 1, 1 / bin_s);
    this.counts = new Float32Array(this.scroll.width * sizes.length);
  }

  /** The number of the first bin, which begins at `first * bin_s`. */
  get first(): number {
    return this.scroll.first;
  }

  get bins(): number {
    return this.scroll.width;
  }

  /** Counts what is new since the last call, for a window that begins at a time. */
  count(from_s: number, populations: readonly { ring: TimeRing; lineOf: LineOf }[]): void {
    const { scroll, counts } = this;
    const lines = this.sizes.length;
    const fresh = scroll.moveTo(
      from_s,
      populations.map(({ ring }) => ring),
    );
    for (let bin = fresh?.[0] ?? 0; bin < (fresh?.[1] ?? 0); bin++) {
      const at = scroll.placeOf(bin) * lines;
      counts.fill(0, at, at + lines);
    }
    for (const { ring, lineOf } of populations)
      scroll.visit(ring, fresh, (bin, cell) => {
        const line = lineOf[cell] ?? -1;
        if (line < 0) return;
        const at = scroll.placeOf(bin) * lines + line;
        counts[at] = (counts[at] as number) + 1;
      });
  }

  /** Spikes a second and cell. */
  rate_hz(line: number, bin: number): number {
    const count = this.counts[this.scroll.placeOf(bin) * this.sizes.length + line] as number;
    return count / (this.bin_s * (this.sizes[line] ?? 1));
  }

  /** The highest rate of a line. */
  highest_hz(line: number): number {
    let highest = 0;
    for (let bin = this.first; bin < this.first + this.bins; bin++)
      highest = Math.max(highest, this.rate_hz(line, bin));
    return highest;
  }
}
