import type { TimeRing } from "./timeRing";

/** Columns by their numbers, counted from time 0: the first, and the one behind the last. */
export type Stretch = readonly [first: number, end: number];

/** What of a ring was drawn: how many numbers were ever in it, and how often some were dropped. */
interface Drawn {
  pushed: number;
  cuts: number;
}

/**
 * The columns of a picture that moves over time: each shows the numbers of one stretch of time, and is drawn when it
 * comes into sight. What was drawn stays, so a picture of many spikes costs what the new ones cost.
 */
export class Scroll {
  /** The number of the first column in sight. */
  first = 0;
  private isEmpty = true;
  private readonly drawn = new Map<TimeRing, Drawn>();

  constructor(
    /** How many columns there are. */
    readonly width: number,
    readonly columns_per_s: number,
  ) {}

  get end(): number {
    return this.first + this.width;
  }

  /** Where a column is kept: a column takes the place of the one that leaves the sight. */
  placeOf(column: number): number {
    return ((column % this.width) + this.width) % this.width;
  }

  /** Moves to a time and returns the columns that come into sight; all of them if some of what was drawn is gone. */
  moveTo(from_s: number, rings: readonly TimeRing[]): Stretch | null {
    if (rings.some((ring) => this.drawn.has(ring) && this.drawn.get(ring)?.cuts !== ring.cuts)) this.empty();
    const before = this.first;
    this.first = Math.floor(from_s * this.columns_per_s + 1e-6);
    const moved = this.first - before;
    if (this.isEmpty || Math.abs(moved) >= this.width) {
      this.isEmpty = false;
      return [this.first, this.end];
    }
    if (moved === 0) return null;
    return moved > 0 ? [before + this.width, this.end] : [this.first, before];
  }

  /** Forgets what was drawn. */
  empty(): void {
    this.isEmpty = true;
    this.drawn.clear();
  }

  /** Calls back with each number in sight that is not drawn yet: of the columns that came into sight, and new ones. */
  visit(ring: TimeRing, fresh: Stretch | null, mark: (column: number, value: number) => void): void {
    const known = this.drawn.get(ring)?.pushed ?? ring.pushed - ring.length;
    const old = Math.max(0, ring.length - (ring.pushed - known));
    this.drawn.set(ring, { pushed: ring.pushed, cuts: ring.cuts });
    if (fresh) {
      const from = ring.indexAt((fresh[0] - 0.01) / this.columns_per_s);
      this.visitRange(
        ring,
        from,
        Math.min(old, ring.indexAt((fresh[1] + 0.01) / this.columns_per_s)),
        fresh,
        mark,
      );
    }
    this.visitRange(ring, old, ring.length, [this.first, this.end], mark);
  }

  private visitRange(
    ring: TimeRing,
    from: number,
    to: number,
    [first, end]: Stretch,
    mark: (column: number, value: number) => void,
  ): void {
    const { columns_per_s } = this;
    for (let index = from; index < to; index++) {
      const column = Math.floor(ring.timeAt(index) * columns_per_s + 1e-6); // times are rounded in different ways
      if (column >= first && column < end) mark(column, ring.valueAt(index));
    }
  }
}
