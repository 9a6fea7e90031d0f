import { useEffect } from "react";
import type { Population } from "../state/types";
import { RingStore } from "./ringStore";
import { Spans } from "./spans";
import type { TimeRing } from "./timeRing";

interface Spikes {
  ids: ArrayLike<number>;
  times_ms: ArrayLike<number>;
}

/** A population keeps 52 seconds of 20 000 spikes a second. */
const store = new RingStore(2 ** 20, "events");

/** The spikes of a population by time; the values are numbers of neurons in the population. */
export const spikesOf = (label: string): TimeRing => store.of(label).ring;

/** The populations without spikes in a recording, which is known of all its time. */
const silent = new Set<string>();
const ALWAYS = new Spans();
ALWAYS.begin(0);

/** When the spikes of a population were heard. */
export const heardOf = (label: string): Spans => (silent.has(label) ? ALWAYS : store.of(label).heard);

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
    for (const one of populations) if (one.silent) silent.add(one.label);
    const leave = populations.map(({ label }) => store.follow(label, `/brain/${label}/spikes`, addSpikes));
    return () => {
      for (const stop of leave) stop();
    };
  }, [populations]);
}
