import type { NodeProps } from "@xyflow/react";
import { baseName } from "../state/paths";
import { counted } from "../ui/counts";
import { Icon } from "../ui/Icon";
import { End } from "./End";
import { FunctionRow } from "./FunctionRow";
import type { BoxNode } from "./flow";
import { LiveRate } from "./LiveRate";
import { findingsAt } from "./model";
import { act, open, select, useDesign } from "./store";
import type { Box, PlacedFinding } from "./types";
import "./boxes.css";

type BoxProps = NodeProps<BoxNode>;

const flows: Record<string, string> = {
  Robot2Neuron: "robot → neurons",
  Neuron2Robot: "neurons → robot",
  Neuron2Monitor: "monitor",
  PythonTransferFunction: "Python",
};

const classOf = ({ kind, is_used }: Box, selected: boolean) =>
  ["box", `box-${kind}`, selected && "is-selected", is_used === false && "is-unused"]
    .filter(Boolean)
    .join(" ");

/** A topic of the robot, or of the room. */
function TopicBox({ data: { box }, selected }: BoxProps) {
  const rate = box.rate_hz ? `${box.rate_hz} Hz` : box.is_heard && !box.is_sent ? "command" : "";
  return (
    <div className={classOf(box, selected)} data-end={box.id}>
      <button type="button" className="box-head" onClick={() => select(box.id)}>
        <span className="mono cut">{box.name}</span>
        <span className="box-sub">
          <span className="cut">{box.type}</span>
          <span>{box.is_known === false ? <Unknown what="topic" /> : rate}</span>
        </span>
      </button>
      <End id={box.id} label={box.name} side="right" look={box.is_used ? "message" : "free"} />
    </div>
  );
}

const Unknown = ({ what }: { what: string }) => <span className="bad-t">no such {what} here</span>;

const Size = ({ box: { size } }: { box: Box }) => (
  <span>{typeof size === "number" && counted(size, "cell")}</span>
);

/** Neurons, and those of them that functions are connected to. */
function PopulationBox({ data: { box }, selected }: BoxProps) {
  return (
    <div className={classOf(box, selected)} data-end={box.id}>
      <button type="button" className="box-head" onClick={() => select(box.id)}>
        <span className="mono cut">{box.name}</span>
        <span className="box-sub">
          {box.is_known === false ? <Unknown what="population" /> : <Size box={box} />}
          <LiveRate of={box.name} />
        </span>
      </button>
      <End id={box.id} label={box.name} side="left" look="free" />
      {box.rows?.map((row) => (
        <div key={row.path} className="box-row mono" data-end={row.path}>
          {row.text}
          <NeuronsEnd id={row.path} label={`${box.name}${row.text}`} />
        </div>
      ))}
    </div>
  );
}

/** Neurons of a brain that is drawn: spikes reach them on the left and leave them on the right. */
function NeuronsBox({ data: { box }, selected }: BoxProps) {
  const findings = useDesign((design) => design.findings);
  const bad = findingsAt(findings, box)[0];
  return (
    <div
      className={classOf(box, selected)}
      data-end={box.id}
      data-bad={bad?.weight === "error" || undefined}
      title={bad?.summary}
    >
      <button type="button" className="box-head" onClick={() => select(box.id)}>
        <span className="mono cut">{box.name}</span>
        <span className="box-sub">
          <span className="cut">{box.type}</span>
          <LiveRate of={box.name} />
          <Size box={box} />
        </span>
      </button>
      <BothEnds id={box.id} label={box.name} box={box} />
      {box.rows?.map((row) => (
        <div key={row.path} className="box-row mono" data-end={row.path}>
          {row.text}
          <BothEnds id={row.path} label={`${box.name}${row.text}`} box={box} />
        </div>
      ))}
    </div>
  );
}

const BothEnds = ({ id, label, box }: { id: string; label: string; box: Box }) => (
  <>
    {box.is_heard && <End id={`into:${id}`} label={`into ${label}`} side="left" look="free" />}
    <End id={id} label={label} side="right" look="free" />
  </>
);

/** The end of neurons has the colour of what it is used for. */
function NeuronsEnd({ id, label }: { id: string; label: string }) {
  const drives = useDesign(({ state }) =>
    state?.wires.some((wire) => wire.kind === "drives" && wire.target_end === id),
  );
  return <End id={id} label={label} side="left" look={drives ? "drives" : "reads"} />;
}

interface HeadProps {
  box: Box;
  /** The worst finding, and how many weigh as much. */
  worst: PlacedFinding | undefined;
  count: number;
  onSelect: () => void;
}

/** The name of a function, its file if that is another one, and how it is. */
function FunctionHead({ box, worst, count, onSelect }: HeadProps) {
  const { file } = box;
  return (
    <button type="button" className="box-head" title={file && `Open ${baseName(file)}`} onClick={onSelect}>
      <span className="mono cut">{box.name}</span>
      <span className="grow" />
      {file && <span className="tag cut">{baseName(file)}</span>}
      {worst && worst.weight !== "note" && (
        <span className={`tag tag-${worst.weight === "error" ? "bad" : "warn"}`} title={worst.summary}>
          <Icon name={worst.weight === "error" ? "error" : "warning"} small />
          {count}
        </span>
      )}
      {box.active === false && <span className="tag">off</span>}
      {box.when && (
        <span className="tag cut" title={`Runs ${box.when}`}>
          {box.when}
        </span>
      )}
      <span className="tag">{flows[box.type ?? ""]}</span>
    </button>
  );
}

/** A transfer function: what it is connected to, and what it computes. */
function FunctionBox({ data: { box }, selected }: BoxProps) {
  const findings = useDesign((design) => design.findings);
  const found = findingsAt(findings, box);
  const monitor = box.type === "Neuron2Monitor";
  const { file } = box;
  const show = file === undefined ? () => select(box.id) : () => void open(file);
  return (
    <div
      className={classOf(box, selected)}
      data-end={file ? undefined : box.id}
      data-bad={found[0]?.weight === "error" || undefined}
      data-off={box.active === false || undefined}
    >
      <FunctionHead
        box={box}
        worst={found[0]}
        count={found.filter(({ weight }) => weight === found[0]?.weight).length}
        onSelect={show}
      />
      {!monitor && box.kind === "function" && (
        <button
          type="button"
          className="box-add nodrag"
          aria-label={`Add a variable to ${box.name}`}
          title="Add a variable"
          onClick={() => void act("add", { path: box.id, field: "local" })}
        >
          <Icon name="plus" small />
        </button>
      )}
      {box.kind === "function" && !monitor && <End id={box.id} label={box.name} side="left" look="free" />}
      {box.rows?.map((row) => (
        <FunctionRow key={row.path} row={row} {...(box.kind === "function" ? {} : { onSelect: show })} />
      ))}
      {box.kind === "python" && <p className="box-hint">opens in the editor</p>}
      {box.kind === "function" && box.rows?.length === 0 && (
        <p className="box-hint">drag a topic or neurons here</p>
      )}
    </div>
  );
}

export const boxTypes = {
  topic: TopicBox,
  population: PopulationBox,
  function: FunctionBox,
  python: FunctionBox,
  other: FunctionBox,
  neurons: NeuronsBox,
};
