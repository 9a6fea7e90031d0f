import type { KeyboardEvent } from "react";
import { baseName } from "../state/paths";
import { EditedMark } from "./FunctionList";
import { openFile, useFunctions } from "./store";

/** The source files; arrows move between them. */
export function FileTabs() {
  const files = useFunctions((state) => state.files);
  const open = useFunctions((state) => state.open);
  const drafts = useFunctions((state) => state.drafts);
  const move = (event: KeyboardEvent<HTMLElement>) => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (step === undefined) return;
    event.preventDefault();
    const at = (files.findIndex(({ path }) => path === open) + step + files.length) % files.length;
    const next = files[at];
    if (next) openFile(next.path);
    event.currentTarget.querySelectorAll("button")[at]?.focus();
  };
  return (
    <div className="tabs" role="tablist" aria-label="Source files" onKeyDown={move}>
      {files.map(({ path }) => (
        <button
          key={path}
          type="button"
          role="tab"
          aria-selected={path === open}
          tabIndex={path === open ? 0 : -1}
          title={path}
          onClick={() => openFile(path)}
        >
          {baseName(path)}
          {path in drafts && <EditedMark />}
        </button>
      ))}
    </div>
  );
}
