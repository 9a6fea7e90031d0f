import { onPast, wire } from "../wire";
import { clock } from "./clock";
import { Spans } from "./spans";
import { TimeRing } from "./timeRing";

/** Gives what puts a message into a ring. */
type Take<T> = (ring: TimeRing) => (message: T, t_s: number) => void;

/** A series of numbers, and when it was heard. */
interface Series {
  topic: string;
  ring: TimeRing;
  /** The values that it had after the time to which the run last went back; events are not kept. */
  left: TimeRing | undefined;
  heard: Spans;
  followers: number;
  stop: () => void;
}

const ROUNDING_S = 1e-6;

/**
 * Series of numbers by key, each heard while somebody follows it. The server sends first what it remembers, so a
 * series is complete however late it is followed; what a seek or a reset undid is forgotten.
 */
export class RingStore {
  private readonly all = new Map<string, Series>();

  /**
   * `capacity`: how many numbers each series keeps at most, a power of two. `kind`: events at the very time to which
   * a run goes back are still to come; values of that time are there.
   */
  constructor(
    private readonly capacity: number,
    private readonly kind: "events" | "values",
  ) {
    const there_s = kind === "values" ? ROUNDING_S : 0;
    clock.onBack((t_s) => {
      for (const series of this.all.values()) forget(series, t_s + there_s);
    });
    onPast((past) => {
      for (const series of this.all.values())
        if (series.topic === past.topic && series.followers > 0) {
          forget(series, past.new ? Number.NEGATIVE_INFINITY : past.from_s);
          series.heard.begin(past.from_s);
        }
    });
    wire.onWithdrawn((topic) => {
      for (const series of this.all.values()) if (series.topic === topic) series.heard.end(clock.now_s);
    });
    wire.onLink(({ state }) => {
      if (state !== "open") for (const series of this.all.values()) series.heard.end(clock.now_s);
    });
  }

  of(key: string): Readonly<Series> {
    return this.series(key, "");
  }

  /** Fills a series from a topic until the returned function is called by all who follow it. */
  follow<T>(key: string, topic: string, take: Take<T>): () => void {
    const series = this.series(key, topic);
    if (series.followers++ === 0) hear(series, topic, take(series.ring));
    return () => {
      if (--series.followers > 0) return;
      series.stop();
      series.heard.end(clock.now_s);
    };
  }

  private series(key: string, topic: string): Series {
    const known = this.all.get(key);
    if (known) return topic ? Object.assign(known, { topic }) : known;
    const ring = new TimeRing(this.capacity);
    const series = {
      topic,
      ring,
      left: this.kind === "values" ? new TimeRing(this.capacity) : undefined,
      heard: new Spans(),
      followers: 0,
      stop: () => undefined,
    };
    this.all.set(key, series);
    return series;
  }
}

function hear<T>(series: Series, topic: string, take: (message: T, t_s: number) => void): void {
  let last_s = Number.NEGATIVE_INFINITY;
  series.stop = wire.subscribe<T>(topic, (message, t_s) => {
    if (t_s < last_s) forget(series, t_s);
    last_s = t_s;
    take(message, t_s);
    if (series.ring.isFull) series.heard.forgetBefore(series.ring.timeAt(0)); // what was there is no silence
    clock.data(t_s);
  });
  wire.recall(topic); // another handler may have heard its past already
}

function forget({ ring, left, heard }: Series, t_s: number): void {
  if (ring.indexAt(t_s) < ring.length) left?.takeOver(ring, t_s);
  ring.forgetFrom(t_s);
  heard.forgetFrom(t_s);
}
