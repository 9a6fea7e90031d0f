import { createContext, type HTMLAttributes, type ReactNode } from "react";

interface PanelFrame {
  /** The buttons that the layout adds to a panel's head. */
  frameTools: ReactNode;
  /** What makes the head a handle to drag the panel by. */
  headProps: HTMLAttributes<HTMLDivElement>;
}

/** Set by the layout around each panel; outside a layout a panel has a plain head. */
export const PanelContext = createContext<PanelFrame>({ frameTools: null, headProps: {} });
