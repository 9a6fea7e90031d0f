import { createContext, type HTMLAttributes, type ReactNode } from "react";

interface PanelFrame {
  /** The panel's name in the layout. */
  id: string;
  /** Which panel of its kind it is, from 1. */
  number: number;
  /** The buttons that the layout adds to a panel's head. */
  frameTools: ReactNode;
  /** What makes the head a handle to drag the panel by. */
  headProps: HTMLAttributes<HTMLDivElement>;
}

/** Set by the layout around each panel; outside a layout a panel has a plain head. */
export const PanelContext = createContext<PanelFrame>({ id: "", number: 1, frameTools: null, headProps: {} });
