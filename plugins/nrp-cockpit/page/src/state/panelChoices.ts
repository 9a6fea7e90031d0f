import { useContext } from "react";
import { create } from "zustand";
import { PanelContext } from "./panelContext";

interface PanelChoices {
  /** By the panel's id. */
  choices: Record<string, string>;
  /** Whether a person chose in this visit, so that it is worth saving. */
  chosen: boolean;
}

/** Which of several things each panel shows: a camera, a kind of plot, a way to look. */
export const usePanelChoices = create<PanelChoices>(() => ({ choices: {}, chosen: false }));

/** What the panel around this component shows, by default `usual`, and what chooses it. */
export function usePanelChoice<T extends string>(usual: T): [T, (choice: T) => void] {
  const { id } = useContext(PanelContext);
  const choice = usePanelChoices(({ choices }) => choices[id] as T | undefined);
  const choose = (next: T) =>
    usePanelChoices.setState(({ choices }) => ({ choices: { ...choices, [id]: next }, chosen: true }));
  return [choice ?? usual, choose];
}
