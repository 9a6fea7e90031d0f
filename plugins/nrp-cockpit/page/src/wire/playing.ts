/** The extent of a recording in simulated time. */
export interface Extent {
  begin_ns: number;
  end_ns: number;
  timestep_ns: number;
}

/** The longest delay that is caught up, as in the pacing of a run. */
const CATCH_UP_MS = 100;
/** Steps at once where no pace limits them. */
const UNPACED_STEPS = 10;

/** The time of a recording that is played, as the server keeps it: in whole steps of the run. */
export class Playing {
  state: "paused" | "running" | "finished" = "paused";
  now_ns: number;
  /** Simulated seconds a wall second; null: as fast as it can. */
  pace: number | null = 1;
  private until_ns: number;
  private left_ns = 0;

  constructor(private readonly extent: Extent) {
    this.now_ns = extent.begin_ns;
    this.until_ns = extent.end_ns;
  }

  play(): void {
    this.runTo(this.extent.end_ns);
  }

  runTo(t_ns: number): void {
    if (this.state === "finished") throw new Error("the run has ended: step back or reset");
    const until_ns = Math.min(this.stepAt(t_ns), this.extent.end_ns);
    if (until_ns <= this.now_ns) throw new Error(`the run is already at ${this.now_ns / 1e9} s`);
    this.until_ns = until_ns;
    this.left_ns = 0;
    this.state = "running";
  }

  pause(): void {
    if (this.state === "running") this.state = "paused";
  }

  /** Goes to the step at or after a time, and stays there. */
  seek(t_ns: number): void {
    const { begin_ns, end_ns } = this.extent;
    this.now_ns = Math.min(Math.max(this.stepAt(t_ns), begin_ns), end_ns);
    this.state = this.now_ns === end_ns ? "finished" : "paused";
  }

  step(count: number): void {
    this.seek(this.now_ns + count * this.extent.timestep_ns);
  }

  /** Goes on by what is due after this wall time; returns whether it moved. */
  advance(wall_ms: number): boolean {
    if (this.state !== "running") return false;
    const { timestep_ns } = this.extent;
    const due_ns =
      this.pace === null
        ? UNPACED_STEPS * timestep_ns
        : this.left_ns + Math.min(wall_ms, CATCH_UP_MS) * 1e6 * this.pace;
    const steps = Math.floor(due_ns / timestep_ns);
    this.left_ns = due_ns - steps * timestep_ns;
    if (steps === 0) return false;
    this.now_ns = Math.min(this.now_ns + steps * timestep_ns, this.until_ns);
    if (this.now_ns === this.until_ns)
      this.state = this.now_ns === this.extent.end_ns ? "finished" : "paused";
    return true;
  }

  private stepAt(t_ns: number): number {
    const { timestep_ns } = this.extent;
    return Math.ceil(Math.round(t_ns) / timestep_ns) * timestep_ns;
  }
}
