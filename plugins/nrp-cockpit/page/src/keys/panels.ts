import { setFull } from "../state/view";

const panels = () => [...document.querySelectorAll<HTMLElement>("[data-panel]")];

/** Moves the focus to the next panel (1) or the one before (-1). */
export function focusNextPanel(step: 1 | -1): void {
  const all = panels();
  const now = all.findIndex((panel) => panel.contains(document.activeElement));
  const next = now < 0 ? (step > 0 ? 0 : all.length - 1) : (now + step + all.length) % all.length;
  all[next]?.focus();
}

/** Opens the panel that has the focus in full size. */
export function fullSizeOfFocused(): void {
  const panel = document.activeElement?.closest<HTMLElement>("[data-panel]");
  if (panel?.dataset.panel) setFull(panel.dataset.panel);
}
