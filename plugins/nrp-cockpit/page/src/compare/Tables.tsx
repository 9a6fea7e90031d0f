import type { Comparison, Pair } from "../difference/comparison";
import { differs, passedOf, timeOf } from "../difference/words";

/** Events, criteria and spikes of both runs beside each other. */
export function Tables({ comparison }: { comparison: Comparison }) {
  const { labels, events, criteria, spikes } = comparison;
  return (
    <div className="compare-tables">
      <Table title="Events" labels={labels} rows={events} shown={timeOf} />
      <Table title="Criteria" labels={labels} rows={criteria} shown={passedOf} />
      <Table title="Spikes" labels={labels} rows={spikes} shown={(count) => String(count ?? 0)} />
    </div>
  );
}

interface TableProps<T> {
  title: string;
  labels: readonly [string, string];
  rows: readonly Pair<T>[];
  shown: (value: T | null) => string;
}

function Table<T>({ title, labels, rows, shown }: TableProps<T>) {
  if (rows.length === 0) return null;
  return (
    <table className="f12">
      <thead>
        <tr>
          <th scope="col">{title}</th>
          {labels.map((label) => (
            <th scope="col" key={label}>
              {label}
            </th>
          ))}
        </tr>
      </thead>
      <tbody>
        {rows.map((row) => (
          <tr key={row.name} data-differs={differs(row) || undefined}>
            <th scope="row">{row.name}</th>
            <td className="num">{shown(row.one)}</td>
            <td className="num">
              {shown(row.other)}
              {differs(row) && <span className="hidden-text"> differs</span>}
            </td>
          </tr>
        ))}
      </tbody>
    </table>
  );
}
