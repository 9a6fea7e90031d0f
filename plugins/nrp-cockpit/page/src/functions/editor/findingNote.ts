import type { Finding } from "../../state/types";

const paragraph = (className: string, text: string) => {
  const element = document.createElement("p");
  element.className = className;
  element.textContent = text;
  return element;
};

/** A finding as it stands beside its line: what, why, and what to do. */
export function findingNote({ summary, why, fix }: Finding): HTMLElement {
  const note = document.createElement("div");
  note.className = "finding-note";
  note.append(paragraph("finding-summary", summary));
  for (const text of [why, fix]) if (text) note.append(paragraph("mut", text));
  return note;
}
