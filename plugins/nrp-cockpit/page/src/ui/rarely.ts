/** Makes a call at most once a period; whatever asked in between is answered by one call at its end. */
export class Rarely {
  private last_ms = Number.NEGATIVE_INFINITY;
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly call: () => void,
    private readonly every_ms: number,
  ) {}

  ask(): void {
    if (this.timer !== undefined) return;
    const left_ms = this.last_ms + this.every_ms - performance.now();
    if (left_ms <= 0) this.make();
    else this.timer = setTimeout(() => this.make(), left_ms);
  }

  /** Forgets what asked. */
  stop(): void {
    clearTimeout(this.timer);
    this.timer = undefined;
  }

  private make(): void {
    this.timer = undefined;
    this.last_ms = performance.now();
    this.call();
  }
}

/** How often a number is written anew (ms): nobody reads faster, and each change lays out the page again. */
export const READABLE_MS = 100;
