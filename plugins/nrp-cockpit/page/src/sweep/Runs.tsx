import { useEffect, useState } from "react";
import { command } from "../state/commands";
import { Button, IconButton } from "../ui/Button";
import { Empty, Panel } from "../ui/Panel";
import { Segmented } from "../ui/Segmented";
import { Chosen } from "./Chosen";
import { type Row, RunTable, type Sorting } from "./RunTable";
import type { Sweep } from "./store";

const CHOICES = [
  { value: "all", label: "All" },
  { value: "passed", label: "Passed" },
  { value: "not passed", label: "Not passed" },
  { value: "failed", label: "Errors" },
] as const;
type Choice = (typeof CHOICES)[number]["value"];

interface Page {
  columns: string[];
  total: number;
  rows: Row[];
}

/** The single runs, a page at a time, sorted and chosen by the server. */
export function Runs({ sweep }: { sweep: Sweep }) {
  const [choice, setChoice] = useState<Choice>("all");
  const [sorting, setSorting] = useState<Sorting>({ column: "run", descending: false });
  const [first, setFirst] = useState(0);
  const [page, setPage] = useState<Page | null>(null);
  const [selected, select] = useState<Row | null>(null);
  const { in_table } = sweep;
  // biome-ignore lint/correctness/useExhaustiveDependencies: a longer table has other rows
  useEffect(() => {
    let isGone = false;
    const { column: sort, descending } = sorting;
    void command<Page>("sweep/runs", { first, sort, descending, choice }).then(
      (found) => !isGone && found && setPage(found),
    );
    return () => {
      isGone = true;
    };
  }, [first, sorting, choice, in_table]);
  const begin = (change: () => void) => () => {
    setFirst(0);
    select(null);
    change();
  };
  const shown = page?.rows.length ?? 0;
  const total = page?.total ?? 0;
  const tools = (
    <>
      <span className="mut f11 num">{total > 0 && `${first + 1} to ${first + shown} of ${total}`}</span>
      <IconButton
        icon="up"
        label="Earlier runs"
        small
        kind="ghost"
        disabled={first === 0 && "These are the first runs."}
        onClick={() => setFirst(Math.max(0, first - shown))}
      />
      <IconButton
        icon="down"
        label="Further runs"
        small
        kind="ghost"
        disabled={first + shown >= total && "These are the last runs."}
        onClick={() => setFirst(first + shown)}
      />
      <Segmented
        label="Which runs"
        choices={CHOICES}
        value={choice}
        onChange={(value) => begin(() => setChoice(value))()}
      />
    </>
  );
  return (
    <Panel title="Runs" tools={tools} className="sweep-runs">
      {page && shown > 0 ? (
        <RunTable
          columns={page.columns}
          rows={page.rows}
          sorting={sorting}
          selected={selected}
          onSort={(next) => begin(() => setSorting(next))()}
          onSelect={select}
        />
      ) : (
        <Empty action={choice !== "all" && <Button onClick={begin(() => setChoice("all"))}>Show all</Button>}>
          {in_table === 0 ? "No run is in the table yet." : "There is no such run."}
        </Empty>
      )}
      {selected && page && <Chosen columns={page.columns} row={selected} />}
    </Panel>
  );
}
