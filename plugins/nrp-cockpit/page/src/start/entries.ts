import type { Entry } from "../state/start";

export interface Section {
  title: string;
  entries: Entry[];
  /** What is said when there are none. */
  none: string;
}

const sections: { title: string; none: string; holds: (entry: Entry) => boolean }[] = [
  {
    title: "Experiments in this folder",
    none: "There is none; nrp new makes one.",
    holds: ({ kind, installed }) => kind === "experiment" && !installed,
  },
  {
    title: "Recordings in this folder",
    none: "There is none; R records a run.",
    holds: ({ kind }) => kind === "recording",
  },
  {
    title: "Sweeps in this folder",
    none: "There is none; nrp sweep makes one.",
    holds: ({ kind }) => kind === "sweep",
  },
  {
    title: "Installed experiments",
    none: "No experiment is installed.",
    holds: ({ kind, installed }) => kind === "experiment" && installed,
  },
];

/**
 * The entries that contain all the words, in sections by origin: those of the folder first, empty sections last. A
 * search shows only the sections in which it finds entries.
 */
export function sectionsOf(entries: readonly Entry[], search: string): Section[] {
  const words = search.toLowerCase().split(/\s+/).filter(Boolean);
  const has = ({ name, text, engines }: Entry) => {
    const all = [name, text, ...engines].join(" ").toLowerCase();
    return words.every((word) => all.includes(word));
  };
  const found = entries.filter(has);
  return sections
    .map(({ title, none, holds }) => ({ title, none, entries: found.filter(holds) }))
    .filter((section) => words.length === 0 || section.entries.length > 0)
    .sort((a, b) => Number(a.entries.length === 0) - Number(b.entries.length === 0));
}

/** An experiment, and its variants below it; what is not installed has none. */
export interface Family {
  entry: Entry;
  variants: Entry[];
}

export function familiesOf(entries: readonly Entry[]): Family[] {
  const families: Family[] = [];
  for (const entry of entries) {
    const { name, variant } = partsOf(entry);
    const head = entry.installed && variant && families.find((one) => one.entry.name === name);
    if (head) head.variants.push(entry);
    else families.push({ entry, variants: [] });
  }
  return families;
}

/** The name of an experiment, and of the variant of it that a shipped name may have. */
export function partsOf({ name, installed }: Entry): { name: string; variant: string } {
  const [first = "", ...rest] = installed ? name.split("/") : [name.replace(/^\.[\\/]/, "")];
  return { name: first, variant: rest.join("/") };
}
