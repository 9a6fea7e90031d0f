import { baseName } from "../state/paths";
import { Button, IconButton } from "../ui/Button";
import { Icon } from "../ui/Icon";
import { Panel } from "../ui/Panel";
import { ConnectMenu } from "./ConnectMenu";
import { ListMoves } from "./ListMoves";
import { ownerOf, partAt, titleOf } from "./model";
import { PartForm } from "./PartForm";
import { act, select, send, useDesign } from "./store";
import type { Box, DesignState, NodeData } from "./types";
import "./form.css";

/** The form of what is selected; of the whole model when nothing is. */
export function Inspector({ state }: { state: DesignState }) {
  const selected = useDesign((design) => design.selected);
  const box = state.boxes.find(({ id }) => id === selected);
  const part = selected === "" ? undefined : partAt(state.model, selected);
  return (
    <div className="designer-form" data-panel="form" tabIndex={-1}>
      {part ? (
        <OfPart path={selected} part={part} />
      ) : box ? (
        <Panel title={box.name} label="Form" sub={box.kind} className="scroll">
          <Outside box={box} />
        </Panel>
      ) : (
        <Whole state={state} />
      )}
    </div>
  );
}

/** The whole model; of a brain that a person wrote there are only the interventions. */
const Whole = ({ state }: { state: DesignState }) => (
  <Panel
    title={state.kind === "brain" ? "The whole brain" : "The whole model"}
    label="Form"
    className="scroll"
  >
    <Form path="" part={state.model} />
    {!state.is_drawn && (
      <p className="form-action mut f12">
        {baseName(state.file)} was written by hand and cannot be edited here. Interventions change its cells
        and synapses in a run; Run begins one with them, and under YAML is what the experiment file needs.
      </p>
    )}
  </Panel>
);

/** A part of the model: what it is, what can be done with it, and what is wrong with it. */
function OfPart({ path, part }: { path: string; part: NodeData }) {
  return (
    <Panel
      title={titleOf(part)}
      label="Form"
      sub={titleOf(part) === part.type ? undefined : <KindOf part={part} />}
      tools={<Tools path={path} />}
      className="scroll"
    >
      <Found path={path} />
      <Form key={path} path={path} part={part} />
      {part.type === "PythonTransferFunction" && (
        <p className="form-action">
          <Button onClick={() => void send("blocks", { path })}>Convert to blocks</Button>
        </p>
      )}
      <ConnectMenu source={path} />
    </Panel>
  );
}

/** The form, once the server has described the metamodel. */
function Form({ path, part }: { path: string; part: NodeData }) {
  const metamodel = useDesign((design) => design.metamodel);
  return metamodel && <PartForm path={path} part={part} />;
}

/** What is wrong with the part, or with something in it. */
function Found({ path }: { path: string }) {
  const findings = useDesign((design) => design.findings);
  return findings
    .filter((finding) => finding.weight !== "note" && finding.path.startsWith(path))
    .map((finding) => (
      <p key={finding.summary} className={`note note-${finding.weight === "error" ? "bad" : "warn"}`}>
        <Icon name={finding.weight === "error" ? "error" : "warning"} />
        {finding.summary}
      </p>
    ));
}

function KindOf({ part }: { part: NodeData }) {
  const summary = useDesign((design) => design.metamodel?.classes[part.type]?.summary);
  return <span title={summary}>{part.type}</span>;
}

function Tools({ path }: { path: string }) {
  const inList = /\/\d+$/.test(path);
  return (
    <>
      {inList && <ListMoves path={path} />}
      {inList && (
        <IconButton
          icon="copy"
          label="Copy"
          shortcut="Ctrl D"
          kind="ghost"
          small
          onClick={() => void act("copy", { path })}
        />
      )}
      <Button kind="ghost" small onClick={() => void act("remove", { path })}>
        Remove
      </Button>
      <IconButton icon="close" label="Close" kind="ghost" small onClick={() => select(ownerOf(path))} />
    </>
  );
}

/** A topic or population: what it is, and what it can be connected to. */
function Outside({ box }: { box: Box }) {
  return (
    <>
      <dl className="form-facts">
        <dt>Name</dt>
        <dd className="mono">{box.name}</dd>
        <dt>{box.kind === "topic" ? "Message" : "Cells"}</dt>
        <dd>{box.kind === "topic" ? box.type : (box.size ?? "unknown")}</dd>
        {box.kind === "neurons" && (
          <>
            <dt>Model</dt>
            <dd className="mono">{box.type}</dd>
          </>
        )}
        {box.kind === "topic" && (
          <>
            <dt>Direction</dt>
            <dd>{box.is_sent ? (box.is_heard ? "sent and heard" : "sent by the robot") : "a command"}</dd>
          </>
        )}
      </dl>
      <ConnectMenu source={box.id} />
    </>
  );
}
