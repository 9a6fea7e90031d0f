import { type Selection, select, useSelection } from "../state/selection";
import { IconButton } from "../ui/Button";
import { Panel } from "../ui/Panel";
import { BodyView } from "./BodyView";
import { NeuronView, PopulationView, ProjectionView } from "./BrainViews";
import { FunctionView } from "./FunctionView";
import { GroupView } from "./GroupView";
import { Outline } from "./Outline";
import "./inspector.css";

/** What is selected: its values, and what may be done with it. */
export function InspectorPanel() {
  const selected = useSelection((state) => state.selected);
  const clear = selected && (
    <IconButton
      icon="close"
      label="Clear the selection"
      shortcut="Esc"
      kind="ghost"
      small
      onClick={() => select(null)}
    />
  );
  return (
    <Panel title="Selected" tools={clear} className="inspector scroll" about={JSON.stringify(selected)}>
      {selected ? <Selected selected={selected} /> : <Nothing />}
    </Panel>
  );
}

function Nothing() {
  return (
    <>
      <p className="inspector-empty mut f12">Click a body, a cell or a projection, or choose one here.</p>
      <Outline />
    </>
  );
}

function Selected({ selected }: { selected: Selection }) {
  switch (selected.kind) {
    case "body":
      return <BodyView name={selected.name} />;
    case "neuron":
      return <NeuronView population={selected.population} index={selected.index} />;
    case "population":
      return <PopulationView label={selected.label} />;
    case "group":
      return <GroupView name={selected.name} />;
    case "projection":
      return <ProjectionView id={selected.id} />;
    case "function":
      return <FunctionView name={selected.name} />;
  }
}
