import { wire } from "../wire";
import { clock } from "./clock";
import { Spans } from "./spans";
import { TimeRing } from "./timeRing";

/** Puts what a message says into a ring. */
type Take<T> = (ring: TimeRing, message: T, t_s: number) => void;

/** A series of numbers, and when it was heard. */
interface Series {
  ring: TimeRing;
  heard: Spans;
  followers: number;
  /** Since when the page waits for its begin, in milliseconds of the wall clock; null: it does not. */
  waits_ms: number | null;
  stop: () => void;
}

const ROUNDING_S = 1e-6;
/** By then a topic that says nothing is silent: what the server sent before it knew of the follower has arrived. */
const SILENT_MS = 500;

/**
 * Series of numbers by key, each heard while somebody follows it. What was heard stays, so a panel that closes and
 * opens again still shows its past; what a seek or a reset undid is forgotten.
 */
export class RingStore {
  private readonly all = new Map<string, Series>();

  /**
   * `capacity`: how many numbers each series keeps at most, a power of two. `kind`: events at the very time to which
   * a run goes back are still to come; values of that time are there.
   */
  constructor(
    private readonly capacity: number,
    kind: "events" | "values",
  ) {
    const there_s = kind === "values" ? ROUNDING_S : 0;
    clock.onRun((t_s, { back, goes }) => {
      const early_ms = goes ? performance.now() - SILENT_MS : Number.POSITIVE_INFINITY;
      for (const series of this.all.values()) {
        if (back) forget(series, t_s + there_s);
        if ((series.waits_ms ?? early_ms) < early_ms) begin(series, t_s);
      }
    });
    clock.onLeap((from_s, to_s) => {
      for (const series of this.all.values()) series.heard.leave(from_s, to_s);
    });
    wire.onLink(({ state }) => {
      for (const series of this.all.values()) {
        if (state === "open") series.waits_ms = series.followers > 0 ? performance.now() : null;
        else series.heard.end(clock.now_s);
      }
    });
  }

  of(key: string): Readonly<Series> {
    return this.series(key);
  }

  /** Fills a series from a topic until the returned function is called by all who follow it. */
  follow<T>(key: string, topic: string, take: Take<T>): () => void {
    const series = this.series(key);
    if (series.followers++ === 0) hear(series, topic, take);
    return () => {
      if (--series.followers > 0) return;
      series.stop();
      series.waits_ms = null;
      series.heard.end(clock.now_s);
    };
  }

  private series(key: string): Series {
    const known = this.all.get(key);
    if (known) return known;
    const ring = new TimeRing(this.capacity);
    const series = { ring, heard: new Spans(), followers: 0, waits_ms: null, stop: () => undefined };
    this.all.set(key, series);
    return series;
  }
}

function hear<T>(series: Series, topic: string, take: Take<T>): void {
  let last_s = Number.NEGATIVE_INFINITY;
  series.waits_ms = performance.now();
  series.stop = wire.subscribe<T>(topic, (message, t_s) => {
    if (t_s < last_s) forget(series, t_s);
    last_s = t_s;
    begin(series, t_s);
    series.heard.include(t_s);
    take(series.ring, message, t_s);
    clock.data(t_s);
  });
}

function begin(series: Series, t_s: number): void {
  if (series.waits_ms !== null) series.heard.begin(t_s);
  series.waits_ms = null;
}

function forget({ ring, heard }: Series, t_s: number): void {
  ring.forgetFrom(t_s);
  heard.forgetFrom(t_s);
}
