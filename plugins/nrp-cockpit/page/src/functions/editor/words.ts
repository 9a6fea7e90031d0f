import type { Completion } from "@codemirror/autocomplete";
import { wire } from "../../wire";

interface Word {
  label: string;
  type: string;
  detail: string;
}

let known: Promise<readonly Completion[]> | null = null;

/** The names of the run as it is now; asked for once, until `forgetWords`. */
export function words(): Promise<readonly Completion[]> {
  known ??= wire
    .call<{ words: Word[] }>("/cockpit/functions/complete")
    .then((answer) => answer.words)
    .catch(() => {
      known = null;
      return [];
    });
  return known;
}

export const forgetWords = (): void => {
  known = null;
};
