import { useBlocked } from "../state/run";
import { Button } from "../ui/Button";
import { Icon } from "../ui/Icon";
import { Menu } from "../ui/Menu";
import { act, show } from "./store";
import type { DesignState } from "./types";

const KINDS = [
  ["Robot2Neuron", "Robot → neurons"],
  ["Neuron2Robot", "Neurons → robot"],
  ["Neuron2Monitor", "Monitor"],
  ["PythonTransferFunction", "Python"],
] as const;

const FIRST_TOPICS = 18;

/** What can be added: functions of each kind, and topics that are not shown yet. */
export function Palette({ state }: { state: DesignState }) {
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
        <Menu
          label="More topics"
          className="btn btn-ghost btn-small"
          items={hidden
            .toSorted((a, b) => a.split("/").length - b.split("/").length)
            .slice(0, FIRST_TOPICS)
            .map((name) => ({ label: name, onSelect: () => void show(name) }))}
        >
          More topics
          <Icon name="down" small />
        </Menu>
      )}
    </div>
  );
}
