import { type KeyboardEvent, useEffect, useMemo } from "react";
import { sameFile } from "../state/paths";
import { usePlace } from "../state/place";
import { useRun } from "../state/run";
import { useView } from "../state/view";
import { Empty, Panel } from "../ui/Panel";
import { ApplyBar } from "./ApplyBar";
import { findingsOf } from "./diagnostics";
import { EditorPanel } from "./EditorPanel";
import { forgetWords } from "./editor/words";
import { FindingList } from "./FindingList";
import { FunctionList } from "./FunctionList";
import { LiteralSlider } from "./LiteralSlider";
import { apply, openFile, useFunctions } from "./store";
import { useReadOnly } from "./useReadOnly";
import "./functions.css";

/** The transfer functions: what they cost, their source to edit while the run goes on, and what is wrong. */
export default function FunctionsView() {
  const count = useRun((run) => run.functions?.functions.length);
  const files = useFunctions((state) => state.files);
  const readOnly = useReadOnly();
  const full = useView((state) => state.full === "source");
  useAskedPlace();
  useEffect(() => {
    if (files.length > 0) forgetWords();
  }, [files]);
  if (count === undefined) return <Notice text="Waiting for the functions." />;
  if (count === 0 && files.length === 0) return <Notice text="This run has no transfer functions." />;
  const key = (event: KeyboardEvent) => {
    if (event.key !== "Enter" || !(event.ctrlKey || event.metaKey) || event.defaultPrevented) return;
    event.preventDefault();
    if (!readOnly) void apply();
  };
  return (
    // biome-ignore lint/a11y/noStaticElementInteractions: Ctrl Enter applies from everywhere in the view
    <div className="functions" data-full={full} onKeyDown={key}>
      <h1 className="hidden-text">Transfer functions</h1>
      <FunctionList />
      <Source readOnly={readOnly} />
      <FindingList />
    </div>
  );
}

const Notice = ({ text }: { text: string }) => (
  <Panel title="Transfer functions">
    <Empty>{text}</Empty>
  </Panel>
);

/** Opens the file of a place that another room asked for; the editor then shows the line. */
function useAskedPlace(): void {
  const asked = usePlace((state) => state.asked);
  const files = useFunctions((state) => state.files);
  useEffect(() => {
    if (!asked || files.length === 0) return;
    const file = files.find(({ path }) => sameFile(path, asked.file));
    if (file) openFile(file.path);
    else usePlace.setState({ asked: null });
  }, [asked, files]);
}

function Source({ readOnly }: { readOnly: string | undefined }) {
  const { files, open, drafts, checked } = useFunctions();
  const ofRun = useRun((run) => run.findings);
  const file = files.find(({ path }) => path === open);
  const findings = useMemo(
    () => (file ? findingsOf(file.path, drafts, checked, ofRun) : []),
    [file, drafts, checked, ofRun],
  );
  if (!file)
    return (
      <Panel title="Source">
        <Empty>These functions are part of an old experiment. They run, but cannot be edited here.</Empty>
      </Panel>
    );
  return (
    <EditorPanel file={file} findings={findings} readOnly={readOnly}>
      {!readOnly && <LiteralSlider path={file.path} />}
      <ApplyBar file={file} readOnly={readOnly} />
    </EditorPanel>
  );
}
