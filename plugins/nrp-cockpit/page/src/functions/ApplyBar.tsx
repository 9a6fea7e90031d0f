import { baseName } from "../state/paths";
import { useBlocked } from "../state/run";
import type { Finding, SourceFile } from "../state/types";
import { Button } from "../ui/Button";
import { conflictsOf, textOf } from "./sources";
import { apply, discard, keepMine, revert, save, useFunctions } from "./store";

interface ApplyBarProps {
  file: SourceFile;
  readOnly: string | undefined;
}

/** What is edited, and the ways on: into the run, back to what runs, back to the disk, onto the disk. */
export function ApplyBar({ file, readOnly }: ApplyBarProps) {
  const state = useFunctions();
  const { drafts, checked, problem, checking, applying } = state;
  const blocked = useBlocked();
  if (readOnly) return <p className="apply-bar mut">{readOnly}</p>;
  const count = Object.keys(drafts).length;
  const conflict = conflictText(conflictsOf(state));
  const nothing = count === 0 && "No file is edited.";
  return (
    <div className="apply-bar">
      <div className="grow" role="status">
        <p className="cut">
          <b>{counted(count)}</b> <Verdict checked={checked} problem={problem} edited={count > 0} />
          {checking && <span className="dim"> Checking…</span>}
        </p>
        {conflict && <p className="warn-t f12">{conflict} Apply would undo that.</p>}
        {count > 0 && !conflict && (
          <p className="mut f11 cut">All edits take effect between two steps, or none does.</p>
        )}
      </div>
      <Button
        kind="ghost"
        disabled={blocked}
        tip="Run the files as they are on disk"
        onClick={() => void revert()}
      >
        Revert to disk
      </Button>
      {conflict && <Button onClick={keepMine}>Keep mine</Button>}
      <Button icon="undo" disabled={nothing} onClick={discard}>
        Discard
      </Button>
      <Button
        icon="save"
        disabled={blocked ?? (!file.editable && "This file cannot be saved from here.")}
        tip={`Save the shown text to ${file.path} (Ctrl S)`}
        onClick={() => void save(file.path, textOf(useFunctions.getState(), file.path))}
      >
        Save
      </Button>
      <Button
        kind={count > 0 ? "primary" : "plain"}
        busy={applying}
        disabled={blocked ?? (nothing || conflict)}
        onClick={() => void apply()}
      >
        Apply
        <span className="wide">
          <kbd>Ctrl</kbd> <kbd>Enter</kbd>
        </span>
      </Button>
    </div>
  );
}

const conflictText = (paths: readonly string[]) =>
  paths.length > 0 && `Somebody else changed ${paths.map(baseName).join(", ")} since you began to edit it.`;

const counted = (count: number) =>
  count === 0 ? "No file is edited." : count === 1 ? "1 file is edited." : `${count} files are edited.`;

interface VerdictProps {
  checked: readonly Finding[];
  problem: string | null;
  edited: boolean;
}

function Verdict({ checked, problem, edited }: VerdictProps) {
  const errors = checked.filter(({ weight }) => weight === "error");
  if (problem) return <span className="bad-t">{problem}</span>;
  if (errors.length === 0 || !edited) return null;
  return (
    <span className="bad-t">
      {errors.length === 1 ? "1 error" : `${errors.length} errors`}: {errors[0]?.summary}
    </span>
  );
}
