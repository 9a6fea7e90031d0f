/** Times that differ less are equal: they are rounded in different ways. */
const SAME_S = 1e-6;

/**
 * No step is so long while a run goes on, or while it stands: this was a seek in a recording, and what lies between
 * is never sent.
 */
const LEAP_S = { going: 3, standing: 0.25 };

/** What the run says with its time: whether it goes on, and whether it went back. */
interface Said {
  goes: boolean;
  back: boolean;
}

/** The simulated time of the newest data, for drawing between two messages of the status. */
export class SimClock {
  /** Zero until the first message. */
  now_s = 0;
  private status_s = 0;
  private goes = false;
  private readonly tickers = new Set<() => void>();
  private readonly listeners = new Set<(t_s: number, said: Said) => void>();
  private readonly leapers = new Set<(from_s: number, to_s: number) => void>();

  /** Data of this time came. */
  data(t_s: number): void {
    const leap_s = this.goes ? LEAP_S.going : LEAP_S.standing;
    if (t_s > this.now_s + leap_s) for (const leaper of this.leapers) leaper(this.now_s, t_s);
    if (t_s > this.now_s) this.now_s = t_s;
    this.tick();
  }

  /**
   * The run says its time. Where it is earlier than before (a seek, a reset), what was later never happened. While
   * the run goes on its status may lag behind the data; while it stands, data that are ahead are from before a seek.
   */
  run(t_s: number, goes: boolean): void {
    const latest_s = goes ? this.status_s : Math.max(this.status_s, this.now_s);
    const back = t_s < latest_s - SAME_S;
    if (back) this.now_s = t_s;
    this.status_s = t_s;
    this.goes = goes;
    for (const listener of this.listeners) listener(t_s, { goes, back });
    this.data(t_s);
  }

  /** Calls back at every change of time or data; drawing code asks for a frame there. */
  onTick(ticker: () => void): () => void {
    this.tickers.add(ticker);
    return () => this.tickers.delete(ticker);
  }

  /** Calls back with each time that the run says. */
  onRun(listener: (t_s: number, said: Said) => void): void {
    this.listeners.add(listener);
  }

  /** Calls back with the times between which the run leapt forward. */
  onLeap(leaper: (from_s: number, to_s: number) => void): void {
    this.leapers.add(leaper);
  }

  /** Asks all plots for a new picture. */
  tick(): void {
    for (const ticker of this.tickers) ticker();
  }
}
