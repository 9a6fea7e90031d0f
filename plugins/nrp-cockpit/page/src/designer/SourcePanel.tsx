import { useState } from "react";
import { notify } from "../state/notices";
import { Button } from "../ui/Button";
import { Icon } from "../ui/Icon";
import { Empty } from "../ui/Panel";
import { Segmented } from "../ui/Segmented";
import { linesOf, partAt } from "./model";
import { SourceEditor } from "./SourceEditor";
import { select, useDesign } from "./store";
import type { DesignState, PlacedFinding } from "./types";
import "./source.css";

type Shown = "xml" | "python" | "yaml" | "findings";

/** The lines of a text that say what is selected. */
function linesShown(state: DesignState, selected: string, shown: Shown): ReadonlySet<number> {
  const part = selected === "" ? undefined : partAt(state.model, selected);
  if (!part?.line) return new Set();
  const [first, last] = linesOf(state.kind === "brain" ? state.python.text : state.xml, part);
  if (shown === "xml" || state.kind === "brain")
    return new Set(Array.from({ length: last - first + 1 }, (_, at) => first + at));
  const lines = state.python.lines.map((line, at) => (line >= first && line <= last ? at + 1 : 0));
  return new Set(lines.filter((line) => line > 0));
}

/** The texts of a kind of drawing, and its findings. */
const choicesOf = (isBrain: boolean, findings: number) =>
  [
    ...(isBrain ? [] : [{ value: "xml", label: "XML" } as const]),
    { value: "python", label: isBrain ? "PyNN" : "Python" },
    ...(isBrain ? [{ value: "yaml", label: "YAML" } as const] : []),
    { value: "findings", label: `Findings ${findings}` },
  ] as const;

/** The model as XML and as Python, both to edit, what was found in it, and the interventions in a brain. */
export function SourcePanel({ state }: { state: DesignState }) {
  const [chosen, setShown] = useState<Shown>("xml");
  const isBrain = state.kind === "brain";
  const shown = chosen === (isBrain ? "xml" : "yaml") ? "python" : chosen;
  const [error, setError] = useState<string | null>(null);
  const count = useDesign((design) => design.findings.length);
  const isEdited = state.is_drawn && (shown === "xml" || shown === "python");
  return (
    <section className="panel designer-source" aria-label="Texts" data-panel="texts" tabIndex={-1}>
      <div className="panel-head">
        <Segmented label="View" choices={choicesOf(isBrain, count)} value={shown} onChange={setShown} />
        <span className="grow" />
        {shown === "yaml" && <CopyYaml text={state.interventions ?? ""} />}
        {isEdited && <InStep error={error} />}
      </div>
      <div className="panel-body">
        <Text state={state} shown={shown} onError={setError} />
      </div>
    </section>
  );
}

interface TextProps {
  state: DesignState;
  shown: Shown;
  onError: (error: string | null) => void;
}

function Text({ state, shown, onError }: TextProps) {
  const selected = useDesign((design) => design.selected);
  const findings = useDesign((design) => design.findings);
  if (shown === "findings") return <Findings findings={findings} />;
  if (shown === "yaml") return <pre className="design-yaml mono scroll">{state.interventions}</pre>;
  return (
    <SourceEditor
      key={`${shown} ${state.file}`}
      language={shown}
      readOnly={!state.is_drawn}
      text={shown === "xml" ? state.xml : state.python.text}
      missing={shown === "python" ? state.python.error : null}
      lines={linesShown(state, selected, shown)}
      onError={onError}
    />
  );
}

const CopyYaml = ({ text }: { text: string }) => (
  <Button
    small
    icon="copy"
    tip="For the experiment file"
    onClick={() =>
      void navigator.clipboard.writeText(text).then(() => notify("The interventions were copied."))
    }
  >
    Copy
  </Button>
);

const InStep = ({ error }: { error: string | null }) => (
  <span className={`row tight f11 in-step ${error ? "bad-t" : "ok-t"}`} role="status">
    <Icon name={error ? "error" : "check"} small />
    <span className="cut" title={error ?? undefined}>
      {error ?? "up to date"}
    </span>
  </span>
);

const icons = { error: "error", warning: "warning", note: "note" } as const;
const colours = { error: "bad-t", warning: "warn-t", note: "mut" } as const;

function Findings({ findings }: { findings: readonly PlacedFinding[] }) {
  if (findings.length === 0) return <Empty>No findings.</Empty>;
  return (
    <ul className="design-findings scroll">
      {findings.map((finding, at) => (
        // biome-ignore lint/suspicious/noArrayIndexKey: two findings may say the same
        <li key={at}>
          <button type="button" onClick={() => select(finding.path)}>
            <span className={colours[finding.weight]}>
              <Icon name={icons[finding.weight]} small />
            </span>
            <span>{finding.summary}</span>
          </button>
        </li>
      ))}
    </ul>
  );
}
