import { useEffect, useRef, useState } from "react";

export type Row = readonly string[];

interface TableProps {
  caption: string;
  columns: readonly string[];
  /** The rows as they are now; the first cell names the row. */
  rows: () => readonly Row[];
}

const EVERY_MS = 2000;

/** What a plot shows, as a table for screen readers; it is written anew when it has changed, now and then. */
export function PlotTable({ caption, columns, rows }: TableProps) {
  const [shown, setShown] = useState<readonly Row[]>([]);
  const latest = useRef(rows);
  useEffect(() => {
    latest.current = rows;
  });
  useEffect(() => {
    const write = () => {
      const next = latest.current();
      setShown((before) => (JSON.stringify(before) === JSON.stringify(next) ? before : next));
    };
    write();
    const timer = window.setInterval(write, EVERY_MS);
    return () => window.clearInterval(timer);
  }, []);
  return (
    <table className="hidden-text">
      <caption>{caption}</caption>
      <thead>
        <tr>
          {columns.map((column) => (
            <th key={column} scope="col">
              {column}
            </th>
          ))}
        </tr>
      </thead>
      <tbody>
        {shown.map(([name = "", ...cells]) => (
          <tr key={name}>
            <th scope="row">{name}</th>
            {cells.map((cell, at) => (
              <td key={columns[at + 1]}>{cell}</td>
            ))}
          </tr>
        ))}
      </tbody>
    </table>
  );
}
