import { baseName } from "../state/paths";
import { useBlocked } from "../state/run";
import { Button, IconButton } from "../ui/Button";
import { Icon } from "../ui/Icon";
import { Menu } from "../ui/Menu";
import { Segmented } from "../ui/Segmented";
import { arrange, open, redo, run, save, turn, undo, useDesign } from "./store";
import type { DesignState } from "./types";

const DRAWN = [
  { value: "functions", label: "Functions" },
  { value: "brain", label: "Brain" },
] as const;

/** Which file is drawn, the way back, and what becomes of it. */
export function Bar({ state }: { state: DesignState }) {
  const blocked = useBlocked();
  const errors = useDesign(({ findings }) => findings.filter(({ weight }) => weight === "error").length);
  const others = [...new Set([...state.files, state.file])].map((file) => ({
    label: baseName(file),
    onSelect: () => void open(file),
  }));
  return (
    <div className="panel designer-bar">
      <Segmented label="Drawn model" choices={DRAWN} value={state.kind} onChange={(to) => void turn(to)} />
      <Menu label="Files" items={others} className="btn btn-ghost designer-file">
        <b className="mono">{baseName(state.file)}</b>
        {!state.is_saved && <span className="designer-dot" title="not saved" />}
        <Icon name="down" small />
      </Menu>
      <span className="hidden-text" role="status">
        {state.is_saved ? "saved" : "not saved"}
      </span>
      <span className="bar-line" />
      <span className="btn-group">
        <IconButton
          icon="undo"
          label="Undo"
          shortcut="Ctrl Z"
          disabled={blocked ?? (!state.can_undo && "Nothing to undo.")}
          onClick={() => void undo()}
        />
        <IconButton
          icon="redo"
          label="Redo"
          shortcut="Ctrl Y"
          disabled={blocked ?? (!state.can_redo && "Nothing to redo.")}
          onClick={() => void redo()}
        />
      </span>
      <Button kind="ghost" icon="arrange" disabled={blocked} onClick={() => void arrange()}>
        Arrange
      </Button>
      <span className="grow" />
      {state.notes.map((note) => (
        <span key={note} className="tag tag-warn" title={note}>
          <Icon name="warning" small />
          {note}
        </span>
      ))}
      {errors > 0 && (
        <span className="tag tag-bad" role="status">
          <Icon name="error" small />
          {errors} {errors === 1 ? "error" : "errors"}
        </span>
      )}
      <Button
        icon="save"
        tip="Save (Ctrl S)"
        disabled={blocked ?? (!state.is_drawn && "Written by hand: it cannot be edited here.")}
        onClick={() => void save()}
      >
        Save
      </Button>
      <Button
        kind="primary"
        icon="play"
        tip="Run it from the beginning (Ctrl Shift Enter)"
        disabled={blocked}
        onClick={() => void run()}
      >
        Run
      </Button>
    </div>
  );
}
