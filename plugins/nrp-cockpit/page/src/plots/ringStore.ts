import { wire } from "../wire";
import { clock } from "./clock";
import { TimeRing } from "./timeRing";

/** Puts what a message says into a ring. */
type Take<T> = (ring: TimeRing, message: T, t_s: number) => void;

/**
 * Series of numbers by key, each heard while somebody follows it. What was heard stays, so a panel that closes and
 * opens again still shows its past; what a seek or a reset undid is forgotten.
 */
export class RingStore {
  private readonly rings = new Map<string, TimeRing>();
  private readonly heard = new Map<string, { followers: number; stop: () => void }>();

  /** `capacity`: how many numbers each series keeps at most, a power of two. */
  constructor(private readonly capacity: number) {
    clock.onBack((t_s) => {
      for (const ring of this.rings.values()) ring.forgetAfter(t_s);
    });
  }

  of(key: string): TimeRing {
    const ring = this.rings.get(key) ?? new TimeRing(this.capacity);
    this.rings.set(key, ring);
    return ring;
  }

  /** Fills a series from a topic until the returned function is called by all who follow it. */
  follow<T>(key: string, topic: string, take: Take<T>): () => void {
    const entry = this.heard.get(key) ?? { followers: 0, stop: this.hear(key, topic, take) };
    this.heard.set(key, entry);
    entry.followers++;
    return () => {
      if (--entry.followers > 0) return;
      this.heard.delete(key);
      entry.stop();
    };
  }

  private hear<T>(key: string, topic: string, take: Take<T>): () => void {
    const ring = this.of(key);
    let last_s = Number.NEGATIVE_INFINITY;
    return wire.subscribe<T>(topic, (message, t_s) => {
      if (t_s < last_s) ring.forgetAfter(t_s);
      last_s = t_s;
      take(ring, message, t_s);
      clock.data(t_s);
    });
  }
}
