import { baseName, sameFile } from "../state/paths";
import { openPlace } from "../state/place";
import { useBlocked, useRecorded, useRun } from "../state/run";
import { select, useSelection } from "../state/selection";
import type { TransferFunction } from "../state/types";
import { counted } from "../ui/counts";
import { Icon } from "../ui/Icon";
import { Empty, Panel } from "../ui/Panel";
import { Switch } from "../ui/Switch";
import { Sparkline } from "./Sparkline";
import { activate, useFunctions } from "./store";

/** The functions of the run: flow, cost, an on and off switch, and why one is in quarantine. */
export function FunctionList() {
  const functions = useRun((run) => run.functions?.functions) ?? [];
  return (
    <div className="functions-list" data-panel="functions" tabIndex={-1}>
      <Panel title="Transfer functions" sub={functions.length} className="scroll">
        {functions.length === 0 && (
          <Empty>A recording contains the files of functions, not their costs.</Empty>
        )}
        <ul>
          {functions.map((one) => (
            <Row key={one.name} one={one} />
          ))}
        </ul>
      </Panel>
    </div>
  );
}

type Failure = NonNullable<TransferFunction["failure"]>;

function Cost({ one }: { one: TransferFunction }) {
  return (
    <p className="row f11 num function-cost">
      <b>{costOf(one)}</b>
      <span className="mut">
        {counted(one.calls, "call")}
        {one.since_s > 0 && ` since ${one.since_s.toFixed(2)} s`}
      </span>
      <span className="grow" />
      <Sparkline values={one.recent_ms} label={`Recent times of ${one.name}`} />
    </p>
  );
}

function costOf({ failure, active, calls, mean_ms }: TransferFunction): string {
  if (failure) return "stopped";
  if (!active) return "off";
  return calls > 0 ? `${mean_ms.toFixed(2)} ms` : "–";
}

function Row({ one }: { one: TransferFunction }) {
  const selected = useSelection(
    ({ selected }) => selected?.kind === "function" && selected.name === one.name,
  );
  const edited = useFunctions(({ drafts }) => Object.keys(drafts).some((path) => sameFile(path, one.file)));
  const hasSource = useFunctions(({ files }) => files.some(({ path }) => sameFile(path, one.file)));
  const blocked = useBlocked();
  const recorded = useRecorded();
  const open = () => {
    select({ kind: "function", name: one.name });
    if (hasSource) openPlace({ file: one.file, line: one.line });
  };
  return (
    <li className="function-row" data-selected={selected} data-quarantined={one.failure !== null}>
      <div className="row">
        <button
          type="button"
          className="function-name mono cut"
          aria-label={hasSource ? `Open ${one.name}` : `Select ${one.name}`}
          onClick={open}
        >
          {one.name}
        </button>
        {edited && <EditedMark />}
        <span className="grow" />
        {one.failure && (
          <span className="tag tag-bad">
            <Icon name="error" small />
            {one.failure.stops ? "stopped the run" : "quarantine"}
          </span>
        )}
        {!recorded && (
          <Switch
            label={`${one.name} runs`}
            on={one.active && !(one.failure && !one.failure.stops)}
            disabled={blocked}
            onChange={(on) => void activate(one.name, on)}
          />
        )}
      </div>
      <p className="row f11 mut">
        {one.flow}
        <span className="dim cut" title={one.file}>
          {baseName(one.file)}
        </span>
      </p>
      {!recorded && <Cost one={one} />}
      {one.failure && <FailureNote failure={one.failure} />}
    </li>
  );
}

/** The dot of what is edited and not applied. */
export function EditedMark() {
  return (
    <span className="edited-mark" title="Edited, not applied">
      <span className="hidden-text">edited</span>
    </span>
  );
}

/** The error itself: the last line of its traceback. The message of the run says the same with all arguments. */
const errorOf = ({ message, traceback }: Failure) => traceback.trimEnd().split("\n").at(-1) || message;

function FailureNote({ failure }: { failure: Failure }) {
  return (
    <details className="function-failure f12">
      <summary>
        <span className="num">{failure.t_s.toFixed(2)} s</span> {errorOf(failure)}
      </summary>
      <pre>{failure.traceback}</pre>
      <p className="f11 mut">{failure.message}</p>
    </details>
  );
}
