const FIRST_CAPACITY = 1024;

/** The last numbers of a series with their times, oldest first, in typed arrays that grow up to a bound. */
export class TimeRing {
  private times = new Float64Array(FIRST_CAPACITY);
  private values = new Float64Array(FIRST_CAPACITY);
  private start = 0;
  private count = 0;
  /** How many numbers were ever added, and how often some were dropped again. */
  pushed = 0;
  cuts = 0;

  /** `capacity`: a power of two; when so many are held, each new one replaces the oldest. */
  constructor(private readonly capacity: number) {}

  get length(): number {
    return this.count;
  }

  /** Whether each new number replaces the oldest. */
  get isFull(): boolean {
    return this.count === this.capacity;
  }

  /** The time of the last number; NaN without one. */
  get lastTime(): number {
    return this.count === 0 ? Number.NaN : this.timeAt(this.count - 1);
  }

  /** Adds a number that is not earlier than the last. */
  push(t_s: number, value: number): void {
    if (this.count === this.times.length && this.count < this.capacity) this.grow();
    const at = this.place(this.count);
    this.times[at] = t_s;
    this.values[at] = value;
    this.pushed++;
    if (this.count < this.times.length) this.count++;
    else this.start = this.place(1);
  }

  timeAt(index: number): number {
    return this.times[this.place(index)] as number;
  }

  valueAt(index: number): number {
    return this.values[this.place(index)] as number;
  }

  /** The index of the first number at this time or later; `length` when there is none. */
  indexAt(t_s: number): number {
    let low = 0;
    let high = this.count;
    while (low < high) {
      const middle = (low + high) >>> 1;
      if (this.timeAt(middle) < t_s) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  /** Calls `visit` with every number from `from_s` to before `to_s`. */
  visit(from_s: number, to_s: number, visit: (t_s: number, value: number) => void): void {
    const end = this.indexAt(to_s);
    for (let index = this.indexAt(from_s); index < end; index++)
      visit(this.timeAt(index), this.valueAt(index));
  }

  /** Drops every number from a time on. */
  forgetFrom(t_s: number): void {
    const kept = this.indexAt(t_s);
    if (kept < this.count) this.cuts++;
    this.count = kept;
  }

  /** Holds the numbers of another series from a time on, and after them only what it has of later times. */
  takeOver(other: TimeRing, from_s: number): void {
    const later: [number, number][] = [];
    this.visit(other.lastTime, Number.POSITIVE_INFINITY, (t_s, value) => {
      if (t_s > other.lastTime) later.push([t_s, value]);
    });
    this.forgetFrom(Number.NEGATIVE_INFINITY);
    other.visit(from_s, Number.POSITIVE_INFINITY, (t_s, value) => this.push(t_s, value));
    for (const [t_s, value] of later) this.push(t_s, value);
  }

  private place(index: number): number {
    return (this.start + index) & (this.times.length - 1);
  }

  private grow(): void {
    this.times = doubled(this.times);
    this.values = doubled(this.values);
  }
}

/** A ring grows only before it turns over for the first time, so its numbers lie at the front. */
function doubled(array: Float64Array<ArrayBuffer>): Float64Array<ArrayBuffer> {
  const larger = new Float64Array(array.length * 2);
  larger.set(array);
  return larger;
}
