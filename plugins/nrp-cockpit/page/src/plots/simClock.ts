/** Times that differ less are equal: they are rounded in different ways. */
const SAME_S = 1e-6;

/** The simulated time of the newest data, for drawing between two messages of the status. */
export class SimClock {
  /** Zero until the first message. */
  now_s = 0;
  private status_s = 0;
  private readonly tickers = new Set<() => void>();
  private readonly listeners = new Set<(t_s: number) => void>();

  /** Data of this time came. */
  data(t_s: number): void {
    if (t_s > this.now_s) this.now_s = t_s;
    this.tick();
  }

  /**
   * The run says its time. Where it is earlier than before (a seek, a reset), what was later never happened. While
   * the run goes on its status may lag behind the data; while it stands, data that are ahead are from before a seek.
   */
  run(t_s: number, goes: boolean): void {
    const latest_s = goes ? this.status_s : Math.max(this.status_s, this.now_s);
    this.status_s = t_s;
    if (t_s < latest_s - SAME_S) {
      this.now_s = t_s;
      for (const listener of this.listeners) listener(t_s);
    }
    this.data(t_s);
  }

  /** Calls back at every change of time or data; drawing code asks for a frame there. */
  onTick(ticker: () => void): () => void {
    this.tickers.add(ticker);
    return () => this.tickers.delete(ticker);
  }

  /** Calls back with each time to which the run goes back. */
  onBack(listener: (t_s: number) => void): void {
    this.listeners.add(listener);
  }

  /** Asks all plots for a new picture. */
  tick(): void {
    for (const ticker of this.tickers) ticker();
  }
}
