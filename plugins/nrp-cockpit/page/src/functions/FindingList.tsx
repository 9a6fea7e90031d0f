import { Text } from "@codemirror/state";
import { sameFile } from "../state/paths";
import { openPlace } from "../state/place";
import { useRun } from "../state/run";
import type { Finding } from "../state/types";
import { Button } from "../ui/Button";
import { Icon } from "../ui/Icon";
import { Empty, Panel } from "../ui/Panel";
import { fixName, newIn } from "./diagnostics";
import { editOf } from "./quickFix";
import { textOf } from "./sources";
import { edit, useFunctions } from "./store";
import { useReadOnly } from "./useReadOnly";

const looks = {
  error: { icon: "error", color: "bad-t" },
  warning: { icon: "warning", color: "warn-t" },
  note: { icon: "note", color: "mut" },
} as const;

/** Everything that was found: in what is edited, then in the run; each unfolds to why and what to do. */
export function FindingList() {
  const ofRun = useRun((run) => run.findings);
  const checked = useFunctions((state) => state.checked);
  const readOnly = useReadOnly();
  const hasSource = useFunctions((state) => state.files.length > 0);
  const findings = [...newIn(checked, ofRun), ...ofRun];
  return (
    <div className="functions-findings" data-panel="findings" tabIndex={-1}>
      <Panel
        title="Findings"
        sub={findings.length}
        tools={readOnly === undefined && hasSource && <Hint />}
        className="scroll"
      >
        {findings.length === 0 ? (
          <Empty>No findings.</Empty>
        ) : (
          <ul>
            {findings.map((finding, at) => (
              // biome-ignore lint/suspicious/noArrayIndexKey: two findings may say the same of the same place
              <FindingRow key={`${at} ${finding.code}`} finding={finding} />
            ))}
          </ul>
        )}
      </Panel>
    </div>
  );
}

const Hint = () => <span className="panel-sub findings-hint">checked as you type, without running</span>;

function FindingRow({ finding }: { finding: Finding }) {
  const { icon, color } = looks[finding.weight];
  const edited = useFunctions(({ drafts }) =>
    Object.keys(drafts).some((path) => finding.file !== null && sameFile(path, finding.file)),
  );
  return (
    <li className="finding-row">
      <details>
        <summary className="row">
          <span className={`row ${color}`}>
            <Icon name={icon} />
            <span className="hidden-text">{finding.weight}</span>
          </span>
          <span className="cut grow">
            {finding.summary}
            {finding.count > 1 && <span className="dim"> ({finding.count} places)</span>}
          </span>
          {edited && <span className="tag">edited</span>}
          <span className="mut">{finding.code}</span>
        </summary>
        {finding.why && <p className="finding-more mut">{finding.why}</p>}
        {finding.fix && <p className="finding-more mut">{finding.fix}</p>}
      </details>
      <QuickFix finding={finding} />
      <FindingPlace finding={finding} />
    </li>
  );
}

/** Mends the draft of the file; the editor can undo it. */
function QuickFix({ finding }: { finding: Finding }) {
  const readOnly = useReadOnly();
  const path = useFunctions(
    ({ files }) => files.find((file) => finding.file !== null && sameFile(file.path, finding.file))?.path,
  );
  const text = useFunctions((state) => (path ? textOf(state, path) : ""));
  const found = path && !readOnly && finding.instead ? editOf(finding, Text.of(text.split("\n"))) : null;
  if (!path || !found) return null;
  const { from, to, insert } = found.changes;
  const mend = () => {
    edit(path, text.slice(0, from) + insert + text.slice(to));
    openPlace({ file: path, line: finding.line ?? 1 });
  };
  return (
    <Button small className="finding-fix" onClick={mend}>
      {fixName(finding)}
    </Button>
  );
}

function FindingPlace({ finding: { file, line } }: { finding: Finding }) {
  const known = useFunctions(({ files }) => files.some(({ path }) => file !== null && sameFile(path, file)));
  if (!file) return null;
  const place = line === null ? file : `${file}:${line}`;
  const name = place.slice(place.lastIndexOf("/") + 1);
  if (!known)
    return (
      <span className="finding-place mono mut cut" title={place}>
        {name}
      </span>
    );
  return (
    <button
      type="button"
      className="finding-place mono cut"
      aria-label={`Open ${place}`}
      onClick={() => openPlace({ file, line: line ?? 1 })}
    >
      {name}
    </button>
  );
}
