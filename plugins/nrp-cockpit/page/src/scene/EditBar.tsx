import { type RefObject, useEffect, useState } from "react";
import { command } from "../state/commands";
import { useBlocked, useRun } from "../state/run";
import { useSelection } from "../state/selection";
import { IconButton } from "../ui/Button";
import { Icon } from "../ui/Icon";
import { Menu } from "../ui/Menu";
import { beginToAdd, undoStep, useEditing } from "./editing";

/** What is added and taken back while bodies are edited, and where the body is that was moved last. */
export function EditBar({ canvas }: { canvas: RefObject<HTMLCanvasElement | null> }) {
  const { isOn, adding, said, steps } = useEditing();
  const blocked = useBlocked();
  const selected = useSelection(({ selected: one }) => (one?.kind === "body" ? one.name : null));
  const models = useModels(isOn);
  if (!isOn) return null;
  const choose = (model: string) => {
    beginToAdd(model);
    canvas.current?.focus(); // its keys place what is chosen, or give it up
  };
  const items = models.map((label) => ({ label, onSelect: () => choose(label) }));
  const last = steps.at(-1)?.text;
  const hint = selected ? "Drag it or press arrows; Shift turns it." : "Drag a body, or select it first.";
  return (
    <div className="scene-edit" role="toolbar" aria-label="Edit the room">
      <Menu label="Add a body" items={items} className="btn btn-small" disabled={blocked}>
        <Icon name="plus" /> Add
      </Menu>
      <IconButton
        icon="undo"
        label={last ?? "Undo"}
        kind="ghost"
        small
        disabled={blocked ?? (last === undefined && "Nothing was moved or added yet.")}
        onClick={() => void undoStep()}
      />
      <span role="status" className="cut num">
        {adding === null ? said || hint : `Click where the ${adding} stands (Enter: the middle).`}
      </span>
    </div>
  );
}

/** The names of what can be added, asked for whenever the room begins to be edited. */
function useModels(isOn: boolean): readonly string[] {
  const [models, setModels] = useState<readonly string[]>([]);
  const file = useRun((run) => run.experiment?.file);
  useEffect(() => {
    if (isOn && file !== undefined)
      void command<{ models: string[] }>("bodies/models").then((found) => setModels(found?.models ?? []));
  }, [isOn, file]);
  return models;
}
