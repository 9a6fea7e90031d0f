import { type ReactNode, useState } from "react";
import type { Finding, SourceFile } from "../state/types";
import { setFull, useView } from "../state/view";
import { IconButton } from "../ui/Button";
import { Segmented } from "../ui/Segmented";
import { Changes } from "./editor/Changes";
import { Editor } from "./editor/Editor";
import { FileTabs } from "./FileTabs";
import { useFunctions } from "./store";

const MODES = [
  { value: "edit", label: "Edit" },
  { value: "changes", label: "Changes" },
] as const;
type Mode = (typeof MODES)[number]["value"];

interface EditorPanelProps {
  file: SourceFile;
  findings: readonly Finding[];
  readOnly: string | undefined;
  /** What stands below the text. */
  children: ReactNode;
}

/** The open file, to edit or beside what runs; the other files are tabs. */
export function EditorPanel({ file, findings, readOnly, children }: EditorPanelProps) {
  const [mode, setMode] = useState<Mode>("edit");
  const draft = useFunctions(({ drafts }) => drafts[file.path]);
  const full = useView((state) => state.full === "source");
  return (
    <section className="functions-source panel" aria-label="Source" data-panel="source" tabIndex={-1}>
      <div className="panel-head">
        <FileTabs />
        <span className="grow" />
        {!readOnly && <Segmented label="View" choices={MODES} value={mode} onChange={setMode} />}
        <IconButton
          icon={full ? "shrink" : "expand"}
          label={full ? "Leave full size" : "Full size"}
          kind="ghost"
          small
          onClick={() => setFull(full ? null : "source")}
        />
      </div>
      <div className="panel-body" role="tabpanel" aria-label={file.path}>
        {mode === "edit" ? (
          <Editor key={file.path} file={file} readOnly={readOnly !== undefined} findings={findings} />
        ) : (
          <Changes file={file} text={draft ?? file.source} />
        )}
      </div>
      {children}
    </section>
  );
}
