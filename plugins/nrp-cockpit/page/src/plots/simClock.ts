/** The simulated time of the newest data, for drawing between two messages of the status. */
export class SimClock {
  /** Zero until the first message. */
  now_s = 0;
  private status_s = 0;
  private readonly tickers = new Set<() => void>();
  private readonly forgetters = new Set<(t_s: number) => void>();

  /** Data of this time came. */
  data(t_s: number): void {
    if (t_s > this.now_s) this.now_s = t_s;
    this.tick();
  }

  /** The run says its time. Where it is earlier than before (a seek, a reset), what was later never happened. */
  run(t_s: number): void {
    if (t_s < this.status_s) {
      this.now_s = t_s;
      for (const forget of this.forgetters) forget(t_s);
    }
    this.status_s = t_s;
    this.data(t_s);
  }

  /** Calls back at every change of time or data; drawing code asks for a frame there. */
  onTick(ticker: () => void): () => void {
    this.tickers.add(ticker);
    return () => this.tickers.delete(ticker);
  }

  /** Calls back with the new time when the run went back. */
  onBack(forget: (t_s: number) => void): void {
    this.forgetters.add(forget);
  }

  /** Asks all plots for a new picture. */
  tick(): void {
    for (const ticker of this.tickers) ticker();
  }
}
