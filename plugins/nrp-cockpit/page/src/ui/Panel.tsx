import { type ReactNode, useContext } from "react";
import { PanelContext } from "../state/panelContext";

interface PanelProps {
  title: string;
  /** The accessible name of the region, when the title alone does not say it. */
  label?: string;
  /** A few words behind the title. */
  sub?: ReactNode;
  /** Controls at the right end of the head. */
  tools?: ReactNode;
  className?: string;
  /** What it is about: something else is shown from its top. */
  about?: string;
  children: ReactNode;
}

/** One room's frame: a region with a head; the frame adds the buttons that the layout offers to every panel. */
export function Panel({ title, label = title, sub, tools, className = "", about, children }: PanelProps) {
  const { number, frameTools, headProps } = useContext(PanelContext);
  const which = number > 1 ? ` ${number}` : "";
  return (
    <section className="panel" aria-label={label + which}>
      <div className="panel-head" {...headProps}>
        <h2>
          {title}
          {which}
        </h2>
        {sub !== undefined && <span className="panel-sub cut">{sub}</span>}
        <span className="grow" />
        {tools}
        {frameTools}
      </div>
      <div key={about} className={`panel-body ${className}`}>
        {children}
      </div>
    </section>
  );
}

/** What a panel says while it has nothing to show: one sentence, and at most one button. */
export function Empty({ children, action }: { children: ReactNode; action?: ReactNode }) {
  return (
    <div className="empty">
      <p>{children}</p>
      {action}
    </div>
  );
}
