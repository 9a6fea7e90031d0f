import { useEffect } from "react";
import { create } from "zustand";
import { type Entry, useStart } from "../state/start";
import { wire } from "../wire";

/** The addresses of pictures by their keys; null: there is none. */
const usePictures = create<Record<string, string | null>>(() => ({}));

/** They are asked for one after another, as the server draws those that nobody has seen yet. */
let last: Promise<void> = Promise.resolve();
const asked = new Set<string>();

function ask(entry: Entry): void {
  if (asked.has(entry.picture)) return;
  asked.add(entry.picture);
  last = last.then(async () => usePictures.setState({ [entry.picture]: await addressOf(entry) }));
}

async function addressOf({ name, installed }: Entry): Promise<string | null> {
  try {
    const { type, data } = await wire.call<{ type: string; data: string }>("/cockpit/start/picture", {
      name,
      ...(installed ? {} : { reads_files: true }),
    });
    return `data:${type};base64,${data}`;
  } catch {
    return null; // a card without a picture says the same
  }
}

/**
 * The address of the picture of an experiment; null: it has none, undefined: it has not come yet. The files of an
 * experiment in the folder are read only when the user has agreed.
 */
export function usePicture(entry: Entry): string | null | undefined {
  const mayRead = useStart(({ readsFiles }) => entry.installed || readsFiles);
  useEffect(() => {
    if (entry.picture && mayRead) ask(entry);
  }, [entry, mayRead]);
  return usePictures(({ [entry.picture]: known }) => (entry.picture && mayRead ? known : (known ?? null)));
}
