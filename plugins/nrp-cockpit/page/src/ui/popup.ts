import { type KeyboardEvent, type MouseEvent, useRef, useState } from "react";

/** Where something opens below a button, and back to the button when it closes. */
export function usePopup() {
  const [at, setAt] = useState<DOMRect | null>(null);
  const place = useRef<HTMLSpanElement>(null);
  return {
    at,
    place,
    toggle: (event: MouseEvent<HTMLElement>) =>
      setAt(at ? null : event.currentTarget.getBoundingClientRect()),
    close: () => {
      setAt(null);
      place.current?.querySelector("button")?.focus();
    },
  };
}

/** Moves the focus with the arrows among these elements below the target; returns whether it did. */
export function movesFocus(event: KeyboardEvent<HTMLElement>, among: string): boolean {
  const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
  if (step === undefined) return false;
  const fields = [...event.currentTarget.querySelectorAll<HTMLElement>(among)];
  const now = fields.indexOf(document.activeElement as HTMLElement);
  fields[(now + step + fields.length) % fields.length]?.focus();
  return true;
}
