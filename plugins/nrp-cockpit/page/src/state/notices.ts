import { create } from "zustand";

export interface Notice {
  id: number;
  weight: "bad" | "info";
  text: string;
}

const SHOWN_MS = 8000;
let nextId = 1;

export const useNotices = create<{ notices: readonly Notice[] }>(() => ({ notices: [] }));

/** Says one sentence at the foot of the page, and reads it to a screen reader; what is bad stays until it is closed. */
export function notify(text: string, weight: Notice["weight"] = "info"): void {
  const notice = { id: nextId++, weight, text };
  useNotices.setState(({ notices }) => ({
    notices: [...notices.filter((one) => one.text !== text), notice].slice(-3),
  }));
  if (weight === "info") window.setTimeout(() => dismiss(notice.id), SHOWN_MS);
}

/** Removes a notice, if it is still shown. */
export function dismissText(text: string): void {
  useNotices.setState(({ notices }) => ({ notices: notices.filter((one) => one.text !== text) }));
}

export function dismiss(id: number): void {
  useNotices.setState(({ notices }) => ({ notices: notices.filter((one) => one.id !== id) }));
}
