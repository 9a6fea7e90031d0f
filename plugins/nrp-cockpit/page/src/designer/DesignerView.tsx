import { ReactFlowProvider } from "@xyflow/react";
import { useEffect } from "react";
import { barredBy, useRecorded, useRun } from "../state/run";
import { Empty, Panel } from "../ui/Panel";
import { Bar } from "./Bar";
import { Canvas } from "./Canvas";
import { Inspector } from "./Inspector";
import { isItem } from "./model";
import { Palette } from "./Palette";
import { SourcePanel } from "./SourcePanel";
import { act, follow, redo, run, save, select, undo, useDesign } from "./store";
import "./designer.css";

const EDITED = "input, textarea, select, .cm-editor";

const removeSelected = (selected: string) => {
  if (isItem(selected)) void act("remove", { path: selected });
};
const copySelected = (selected: string) => {
  if (isItem(selected)) void act("copy", { path: selected });
};

/** What keys do anywhere in the designer; those of texts belong to the texts. */
const keys: Record<string, (selected: string) => void> = {
  "Ctrl+z": () => void undo(),
  "Ctrl+y": () => void redo(),
  "Ctrl+d": copySelected,
  Delete: removeSelected,
  Backspace: removeSelected,
  Escape: () => select(""),
};
const everywhere: Record<string, () => void> = {
  "Ctrl+s": () => void save(),
  "Ctrl+Shift+Enter": () => void run(),
};

/** Before the keys of the page, which are heard at the window. */
function useDesignerKeys(): void {
  useEffect(() => {
    document.addEventListener("keydown", press);
    return () => document.removeEventListener("keydown", press);
  }, []);
}

function press(event: KeyboardEvent): void {
  const modifiers = `${event.ctrlKey || event.metaKey ? "Ctrl+" : ""}${event.shiftKey ? "Shift+" : ""}`;
  const name = modifiers + (event.key.length === 1 ? event.key.toLowerCase() : event.key);
  const typing = (event.target as HTMLElement).closest(EDITED) !== null;
  const does = everywhere[name] ?? (typing ? undefined : keys[name]);
  if (!does || event.defaultPrevented || document.querySelector("dialog[open], [role=menu]")) return;
  event.preventDefault();
  does(useDesign.getState().selected);
}

/** The transfer functions or the brain as boxes and wires, the form of what is selected, and the texts that say the same. */
export default function DesignerView() {
  useDesignerKeys();
  const barred = useRun(barredBy);
  const recorded = useRecorded();
  const open = useRun((now) => now.link.state === "open");
  const state = useDesign((design) => design.state);
  useEffect(() => (open && !recorded ? follow() : undefined), [open, recorded]);
  if (recorded) return <Notice text="This is a recording: the designer needs a live run." />;
  if (!state) return <Notice text={barred ?? "Waiting for the model."} />;
  return (
    <div className="designer">
      <h1 className="hidden-text">Designer</h1>
      <Bar state={state} />
      <section className="panel designer-canvas" aria-label="Drawing" data-panel="drawing" tabIndex={-1}>
        <Palette state={state} />
        <ReactFlowProvider>
          <Canvas state={state} />
        </ReactFlowProvider>
      </section>
      <Inspector state={state} />
      <SourcePanel state={state} />
    </div>
  );
}

const Notice = ({ text }: { text: string }) => (
  <Panel title="Designer">
    <Empty>{text}</Empty>
  </Panel>
);
