import { Icon } from "../ui/Icon";
import { type Cell, shown } from "./words";

export interface Row {
  cells: Cell[];
  /** The words of the command that opens this run; null: the folder does not say of which experiment. */
  command: string[] | null;
}

export interface Sorting {
  column: string;
  descending: boolean;
}

interface Props {
  columns: readonly string[];
  rows: readonly Row[];
  sorting: Sorting;
  selected: Row | null;
  onSort: (sorting: Sorting) => void;
  onSelect: (row: Row) => void;
}

const classOf = (cell: Cell) => (typeof cell === "number" ? "sweep-number" : undefined);

/** Some runs; a head sorts by its column, a row opens its details. */
export function RunTable({ columns, rows, sorting, selected, onSort, onSelect }: Props) {
  const [sample] = rows;
  return (
    // biome-ignore lint/a11y/noNoninteractiveTabindex: what scrolls must be reached by keyboard
    <section className="scroll sweep-table" tabIndex={0} aria-label="Table of runs">
      <table>
        <thead>
          <tr>
            {columns.map((column, at) => (
              <Head
                key={column}
                column={column}
                sorting={sorting}
                className={classOf(sample?.cells[at] ?? null)}
                onSort={onSort}
              />
            ))}
          </tr>
        </thead>
        <tbody>
          {rows.map((row) => (
            <tr key={shown(row.cells[0] ?? null)} data-on={row === selected || undefined}>
              {row.cells.map((cell, at) => (
                <td key={columns[at]} className={classOf(cell)} title={String(cell ?? "")}>
                  {at === 0 ? (
                    <button type="button" className="sweep-run" onClick={() => onSelect(row)}>
                      {shown(cell)}
                    </button>
                  ) : (
                    shown(cell)
                  )}
                </td>
              ))}
            </tr>
          ))}
        </tbody>
      </table>
    </section>
  );
}

interface HeadProps {
  column: string;
  sorting: Sorting;
  className: string | undefined;
  onSort: (sorting: Sorting) => void;
}

function Head({ column, sorting, className, onSort }: HeadProps) {
  const isOn = sorting.column === column;
  const order = sorting.descending ? "descending" : "ascending";
  return (
    <th scope="col" className={className} aria-sort={isOn ? order : undefined}>
      <button type="button" onClick={() => onSort({ column, descending: isOn && !sorting.descending })}>
        {column}
        {isOn && <Icon name={sorting.descending ? "down" : "up"} small />}
      </button>
    </th>
  );
}
