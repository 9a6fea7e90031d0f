import type { Body, Experiment, Status } from "../state/types";
import type { View } from "../state/view";

/** What the page knows of what the person did. */
export interface Seen {
  experiment: Pick<Experiment, "bodies">;
  status: Pick<Status, "state">;
  /** The kind of what is selected. */
  selected: string | undefined;
  view: View;
}

interface Hint {
  id: string;
  text: (seen: Seen) => string;
  isDone: (seen: Seen) => boolean;
}

/** Whether the experiment gave the topic of its colour a name: that colour matters to the run. */
const hasNamedColour = ({ name, colorable }: Body) =>
  colorable !== null && !colorable.startsWith(`/${name}/`);

/** The first steps of a first visit, in their order. */
export const hints: readonly Hint[] = [
  {
    id: "play",
    text: () => "Press Play (Space)",
    isDone: ({ status }) => status.state === "running",
  },
  {
    id: "body",
    text: ({ experiment }) => {
      const coloured = experiment.bodies.find(hasNamedColour);
      return coloured
        ? `Click ${coloured.name} in the scene and choose a colour`
        : "Click a body in the scene";
    },
    isDone: ({ selected }) => selected === "body",
  },
  {
    id: "functions",
    text: () => "Open Functions (2) and change a line while the run continues",
    isDone: ({ view }) => view === "functions",
  },
];

/** The hints that were followed, with those that were followed just now; the same set when none was. */
export function followed(done: ReadonlySet<string>, seen: Seen): ReadonlySet<string> {
  const now = hints.filter((hint) => !done.has(hint.id) && hint.isDone(seen));
  return now.length > 0 ? new Set([...done, ...now.map(({ id }) => id)]) : done;
}

/** The next hint to follow, and its number. */
export function nextHint(done: ReadonlySet<string>): { hint: Hint; number: number } | null {
  const at = hints.findIndex(({ id }) => !done.has(id));
  const hint = hints[at];
  return hint ? { hint, number: at + 1 } : null;
}
