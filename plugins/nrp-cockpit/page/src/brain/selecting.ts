import type { KeyboardEvent } from "react";
import { type Selection, select } from "../state/selection";

/** What makes an element of the graph a button that selects something. */
export const selecting = (name: string, selection: Selection, selected: Selection | null) => ({
  role: "button",
  tabIndex: 0,
  "aria-label": name,
  "aria-pressed": same(selection, selected),
  onClick: () => select(selection),
  onKeyDown: (event: KeyboardEvent) => {
    if (event.key !== "Enter" && event.key !== " ") return;
    event.preventDefault();
    select(selection);
  },
});

function same(a: Selection, b: Selection | null): boolean {
  if (b === null || a.kind !== b.kind) return false;
  return Object.entries(a).every(([key, value]) => b[key as keyof Selection] === value);
}
