import { useEffect } from "react";
import { keymap } from "./keymap";

const EDITED = "input:not([type=range]), textarea, select, [contenteditable=true]";
/** The keys that move the focus. */
const MOVES = ["Tab", "F6", "ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown"];
const OPERATED = 'button, a, summary, [role="menuitem"], [role="separator"], input';

/** A key press as text: `Shift+R`, `Ctrl+Enter`, `?`. Shift is said only where it does not change a sign. */
export function keyOf(event: Pick<KeyboardEvent, "key" | "ctrlKey" | "metaKey" | "shiftKey">): string {
  const sign = event.key.length === 1 && event.key.toLowerCase() === event.key.toUpperCase();
  const shift = event.shiftKey && !sign ? "Shift+" : "";
  return `${event.ctrlKey || event.metaKey ? "Ctrl+" : ""}${shift}${event.key}`;
}

/** Whether the focus was last set by the pointer: then Space is for the run, not for the button that was clicked. */
let pointed = false;

/** Whether a key belongs to what has the focus: letters to a text, Space and Enter to a button. */
export function belongsTo(target: Element | null, key: string): boolean {
  if (target?.matches(EDITED) || target?.closest(".cm-editor")) return key !== "F6" && key !== "Shift+F6";
  if (document.querySelector("dialog[open], [role=menu]")) return true;
  if (key === " " && pointed) return false;
  return (key === " " || key === "Enter") && target !== null && target.matches(OPERATED);
}

function leaveFocus(): void {
  if (document.activeElement instanceof HTMLElement) document.activeElement.blur();
}

/** Acts on the keys of the map, for as long as the page lives. */
export function useKeys(): void {
  useEffect(() => {
    const point = () => {
      pointed = true;
    };
    const press = (event: KeyboardEvent) => {
      const key = keyOf(event);
      pointed &&= !MOVES.includes(event.key);
      if (event.defaultPrevented || event.altKey || belongsTo(event.target as Element | null, key)) return;
      const entry = keymap.find(({ keys }) => keys.includes(key));
      if (!entry?.run) return;
      event.preventDefault();
      if (key === " ") leaveFocus(); // a button would act when the key goes up
      entry.run(event);
    };
    window.addEventListener("pointerdown", point, true);
    window.addEventListener("keydown", press);
    return () => {
      window.removeEventListener("pointerdown", point, true);
      window.removeEventListener("keydown", press);
    };
  }, []);
}
