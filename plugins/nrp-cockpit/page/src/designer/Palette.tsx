import { useBlocked } from "../state/run";
import { Button } from "../ui/Button";
import { Chooser } from "../ui/Chooser";
import { act, show, turn } from "./store";
import type { DesignState } from "./types";

const KINDS = [
  ["Robot2Neuron", "Robot → neurons"],
  ["Neuron2Robot", "Neurons → robot"],
  ["Neuron2Monitor", "Monitor"],
  ["PythonTransferFunction", "Python"],
] as const;

/** What can be added to what is drawn. */
export const Palette = ({ state }: { state: DesignState }) =>
  state.kind === "brain" ? <OfBrain state={state} /> : <OfFunctions state={state} />;

/** Populations; a brain that a person wrote is left alone, and another one can be drawn. */
function OfBrain({ state }: { state: DesignState }) {
  const blocked = useBlocked();
  return (
    <div className="panel-head">
      {state.is_drawn ? (
        <>
          <h2>Add</h2>
          <Button
            kind="ghost"
            small
            icon="plus"
            disabled={blocked}
            onClick={() => void act("add", { path: "", field: "population" })}
          >
            Population
          </Button>
          <span className="mut f11">Drag from one population to another to connect them.</span>
        </>
      ) : (
        <>
          <h2>The brain of the experiment</h2>
          <span className="grow" />
          <Button small icon="plus" disabled={blocked} onClick={() => void turn("new brain")}>
            Draw a new brain
          </Button>
        </>
      )}
    </div>
  );
}

/** Functions of each kind, and topics that are not shown yet. */
function OfFunctions({ state }: { state: DesignState }) {
  const blocked = useBlocked();
  const shown = new Set(state.boxes.map(({ name }) => name));
  const hidden = Object.keys(state.topics).filter((name) => !shown.has(name));
  return (
    <div className="panel-head">
      <h2>Add</h2>
      {KINDS.map(([type, label]) => (
        <Button
          key={type}
          kind="ghost"
          small
          icon="plus"
          disabled={blocked}
          onClick={() => void act("add", { path: "", field: "transfer_function", type })}
        >
          {label}
        </Button>
      ))}
      <span className="grow" />
      {hidden.length > 0 && (
        <Chooser
          kind="ghost"
          small
          title="More topics"
          search="Search the topics"
          choices={() => hidden.toSorted((a, b) => a.split("/").length - b.split("/").length)}
          textOf={(name) => name}
          none="No topic matches."
          onChoose={(name) => void show(name)}
        >
          More topics
        </Chooser>
      )}
    </div>
  );
}
