import { useRun } from "../state/run";
import { select } from "../state/selection";
import { type Branch, bodiesOf, groupsOf, populationsOf } from "./everything";

/** Everything that can be selected, as nested lists: the scene and the brain for keyboard and screen reader. */
export function Outline() {
  const experiment = useRun((run) => run.experiment);
  if (!experiment) return null;
  return (
    <nav className="outline" aria-label="Contents of the run">
      <Group title="Bodies" branches={bodiesOf(experiment)} />
      <Group title="Brain" branches={populationsOf(experiment)} />
      <Group title="Groups of cells" branches={groupsOf(experiment)} />
    </nav>
  );
}

function Group({ title, branches }: { title: string; branches: readonly Branch[] }) {
  if (branches.length === 0) return null;
  return (
    <details open>
      <summary>{title}</summary>
      <Branches branches={branches} />
    </details>
  );
}

function Branches({ branches }: { branches: readonly Branch[] }) {
  return (
    <ul>
      {branches.map(({ name, note, to, parts = [], folded }) => (
        <li key={name + JSON.stringify(to)}>
          {folded ? (
            <details>
              <summary>
                {name} <span className="dim f11">{note}</span>
              </summary>
              <Branches branches={folded} />
            </details>
          ) : (
            <>
              <button type="button" className="inspector-link" onClick={() => select(to)}>
                {name}
              </button>
              <span className="dim f11">{note}</span>
            </>
          )}
          {parts.length > 0 && <Branches branches={parts} />}
        </li>
      ))}
    </ul>
  );
}
