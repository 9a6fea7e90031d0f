import type { TimeRing } from "../../plots/timeRing";

/** Long before any run: the cell has not fired. */
export const NEVER_S = -1e6;

/** When each cell of a population last fired; follows a ring of spikes and costs what the new ones cost. */
export class Fired {
  readonly times_s: Float32Array;
  private pushed = 0;
  private cuts = 0;

  constructor(
    private readonly ring: TimeRing,
    size: number,
  ) {
    this.times_s = new Float32Array(size).fill(NEVER_S);
  }

  /** Takes over the spikes since the last call, and returns whether there were any, or some were undone. */
  update(): boolean {
    const { ring, times_s } = this;
    if (ring.pushed === this.pushed && ring.cuts === this.cuts) return false;
    if (ring.cuts !== this.cuts) {
      times_s.fill(NEVER_S);
      this.pushed = ring.pushed - ring.length;
    }
    const first = Math.max(0, ring.length - (ring.pushed - this.pushed));
    for (let at = first; at < ring.length; at++) times_s[ring.valueAt(at)] = ring.timeAt(at);
    this.pushed = ring.pushed;
    this.cuts = ring.cuts;
    return true;
  }
}
