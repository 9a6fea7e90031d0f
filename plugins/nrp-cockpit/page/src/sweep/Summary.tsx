import { Empty, Panel } from "../ui/Panel";
import type { Sweep } from "./store";
import { meanOf, shown } from "./words";

/** A line for each combination of values, over all seeds. */
export function Summary({ sweep }: { sweep: Sweep }) {
  const { keys, measures, groups, more_groups } = sweep;
  const isDecided = sweep.passed + sweep.not_passed > 0;
  return (
    <Panel title="Combinations" sub="mean ± standard deviation over the seeds" className="scroll sweep-table">
      {groups.length === 0 ? (
        <Empty>No run is in the table yet.</Empty>
      ) : (
        <table>
          <thead>
            <tr>
              {keys.map(({ key, short }) => (
                <th key={key} scope="col" title={key}>
                  {short}
                </th>
              ))}
              {["runs", "passed", ...measures].map((name) => (
                <th key={name} scope="col" className="sweep-number">
                  {name}
                </th>
              ))}
            </tr>
          </thead>
          <tbody>
            {groups.map((group) => (
              <tr key={Object.values(group.values).join(" ")}>
                {keys.map(({ key }) => (
                  <td key={key} className="num">
                    {shown(group.values[key] ?? null)}
                  </td>
                ))}
                <td className="sweep-number">{group.runs}</td>
                <td className="sweep-number">{isDecided ? group.passed : "–"}</td>
                {measures.map((name) => (
                  <td key={name} className="sweep-number">
                    {meanOf(group, name)}
                  </td>
                ))}
              </tr>
            ))}
          </tbody>
        </table>
      )}
      {more_groups > 0 && <p className="dim sweep-more">and {more_groups} more in results.csv</p>}
    </Panel>
  );
}
