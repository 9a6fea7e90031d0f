import { create } from "zustand";

/** The weights of a projection at a moment: a histogram, and the smallest, mean and largest one. */
export interface Seen {
  t_s: number;
  counts: number[];
  borders: number[];
  summary: [number, number, number] | null;
}

const MOST = 2;

/** The pinned moments of projections, by their ids; they stay while other things are selected. */
export const usePins = create<{ pins: Readonly<Record<string, readonly Seen[]>> }>(() => ({ pins: {} }));

const change = (id: string, next: (pins: readonly Seen[]) => readonly Seen[]): void =>
  usePins.setState(({ pins }) => ({ pins: { ...pins, [id]: next(pins[id] ?? []) } }));

/** Keeps a moment to be compared; a third one replaces the second. */
export const pin = (id: string, seen: Seen): void =>
  change(id, (pins) => [...pins.filter(({ t_s }) => t_s !== seen.t_s).slice(0, MOST - 1), seen]);

export const unpin = (id: string, t_s: number): void =>
  change(id, (pins) => pins.filter((one) => one.t_s !== t_s));

/** Outlines of histograms on a common axis, as points of lines in a box of width and height 1. */
export function outlinesOf(all: readonly Pick<Seen, "counts" | "borders">[]): [number, number][][] {
  const borders = all.flatMap((one) => one.borders);
  const [least, most] = [Math.min(...borders), Math.max(...borders)];
  const x = (weight: number) => (most > least ? (weight - least) / (most - least) : 0.5);
  const density = ({ counts, borders: own }: Pick<Seen, "counts" | "borders">, at: number) =>
    (counts[at] ?? 0) / Math.max(1e-300, (own[at + 1] ?? 0) - (own[at] ?? 0));
  const highest = Math.max(...all.flatMap((one) => one.counts.map((_, at) => density(one, at))), 1e-300);
  return all.map((one) => {
    const steps = one.counts.flatMap((_, at): [number, number][] => {
      const y = density(one, at) / highest;
      return [
        [x(one.borders[at] ?? 0), y],
        [x(one.borders[at + 1] ?? 0), y],
      ];
    });
    return [[steps[0]?.[0] ?? 0, 0], ...steps, [steps.at(-1)?.[0] ?? 0, 0]];
  });
}
