import { useEffect } from "react";
import type { Population } from "../state/types";
import { RingStore } from "./ringStore";
import type { Spans } from "./spans";
import type { TimeRing } from "./timeRing";

interface Spikes {
  ids: ArrayLike<number>;
  times_ms: ArrayLike<number>;
}

/** A population keeps 52 seconds of 20 000 spikes a second. */
const store = new RingStore(2 ** 20, "events");

/** The spikes of a population by time; the values are numbers of neurons in the population. */
export const spikesOf = (label: string): TimeRing => store.of(label).ring;

/** When the spikes of a population were heard. */
export const heardOf = (label: string): Spans => store.of(label).heard;

/** Adds the spikes of a step; those that are there already, because the step is taken again, are replaced. */
export function addSpikes(ring: TimeRing): (spikes: Spikes) => void {
  return ({ ids, times_ms }) => {
    ring.forgetFrom((times_ms[0] ?? Number.POSITIVE_INFINITY) / 1000);
    for (let at = 0; at < ids.length; at++) ring.push((times_ms[at] ?? 0) / 1000, ids[at] ?? 0);
  };
}

/** Hears the spikes of these populations while the component is mounted. */
export function useSpikes(populations: readonly Population[]): void {
  useEffect(() => {
    const leave = populations.map(({ label }) => store.follow(label, `/brain/${label}/spikes`, addSpikes));
    return () => {
      for (const stop of leave) stop();
    };
  }, [populations]);
}
