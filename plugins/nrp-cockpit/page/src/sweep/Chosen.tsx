import { notify } from "../state/notices";
import { Button } from "../ui/Button";
import type { Row } from "./RunTable";
import { inShell, shown } from "./words";

/** One run: the error that ended it, and the command that opens it in the cockpit. */
export function Chosen({ columns, row }: { columns: readonly string[]; row: Row }) {
  const cell = (name: string) => row.cells[columns.indexOf(name)] ?? null;
  const text = row.command && inShell(row.command);
  const copy = () => {
    if (text) void navigator.clipboard.writeText(text).then(() => notify("The command was copied."));
  };
  return (
    <section className="sweep-chosen" aria-label="Selected run">
      <b className="num">Run {shown(cell("run"))}</b>
      {cell("error") !== null && <p className="bad-t">{shown(cell("error"))}</p>}
      {cell("problems") !== null && <p className="warn-t">{shown(cell("problems"))}: see nrp explain CODE</p>}
      {text ? (
        <div className="row">
          <code className="grow sweep-command">{text}</code>
          <Button small icon="copy" onClick={copy}>
            Copy
          </Button>
        </div>
      ) : (
        <p className="mut">This folder was made by an earlier version, which does not say of which file.</p>
      )}
    </section>
  );
}
