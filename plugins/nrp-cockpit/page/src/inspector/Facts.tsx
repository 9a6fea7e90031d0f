import type { ReactNode } from "react";

/** A section of the inspector under its own heading. */
export function Section({ title, note, children }: { title: string; note?: ReactNode; children: ReactNode }) {
  return (
    <section className="panel-section" aria-label={title}>
      <h3>
        {title}
        {note !== undefined && (
          <>
            <span className="grow" />
            <span className="dim inspector-note">{note}</span>
          </>
        )}
      </h3>
      {children}
    </section>
  );
}

/** The name of what is selected, and a few words about it. */
export function Title({ name, children }: { name: string; children?: ReactNode }) {
  return (
    <div className="panel-section inspector-title">
      <h3 className="inspector-name cut" title={name}>
        {name}
      </h3>
      <p className="mut f12">{children}</p>
    </div>
  );
}

/** Names and values, one a line. */
export function Facts({ children }: { children: ReactNode }) {
  return <dl className="inspector-facts">{children}</dl>;
}

/** A line of facts; without a value it is left out. */
export function Fact({ name, children }: { name: string; children: ReactNode }) {
  if (children === null || children === undefined) return null;
  return (
    <div>
      <dt>{name}</dt>
      <dd className="num">{children}</dd>
    </div>
  );
}
