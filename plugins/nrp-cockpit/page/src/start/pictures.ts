import { useEffect } from "react";
import { create } from "zustand";
import { wire } from "../wire";

/** The addresses of pictures by their keys; null: there is none. */
const usePictures = create<Record<string, string | null>>(() => ({}));

/** They are asked for one after another, as the server draws those that nobody has seen yet. */
let last: Promise<void> = Promise.resolve();
const asked = new Set<string>();

function ask(name: string, key: string): void {
  if (asked.has(key)) return;
  asked.add(key);
  last = last.then(async () => usePictures.setState({ [key]: await addressOf(name) }));
}

async function addressOf(name: string): Promise<string | null> {
  try {
    const { type, data } = await wire.call<{ type: string; data: string }>("/cockpit/start/picture", {
      name,
    });
    return `data:${type};base64,${data}`;
  } catch {
    return null; // a card without a picture says the same
  }
}

/** The address of the picture of an experiment; null: it has none, undefined: it has not come yet. */
export function usePicture(name: string, key: string): string | null | undefined {
  useEffect(() => {
    if (key) ask(name, key);
  }, [name, key]);
  return usePictures((pictures) => (key ? pictures[key] : null));
}
