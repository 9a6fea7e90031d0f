import { setDiagnostics } from "@codemirror/lint";
import { EditorState } from "@codemirror/state";
import { EditorView } from "@codemirror/view";
import { useEffect, useRef } from "react";
import { sameFile } from "../../state/paths";
import { usePlace } from "../../state/place";
import type { Finding, SourceFile } from "../../state/types";
import { diagnosticsOf } from "../diagnostics";
import { literalAt } from "../literal";
import { difference } from "../quickFix";
import { textOf } from "../sources";
import { atNumber, useFunctions } from "../store";
import { access, accessOf, editing } from "./extensions";

/** The editors of files that are not open now: their text, cursor and undo history. */
const kept = new Map<string, EditorState>();

interface EditorProps {
  file: SourceFile;
  readOnly: boolean;
  findings: readonly Finding[];
}

/** The editor of one file; render it with the path as its key. */
export function Editor({ file, readOnly, findings }: EditorProps) {
  const host = useRef<HTMLDivElement>(null);
  const view = useRef<EditorView | null>(null);
  const first = useRef({ file, readOnly });
  useEffect(() => {
    const editor = openEditor(host.current as HTMLElement, first.current.file, first.current.readOnly);
    const { path } = first.current.file;
    view.current = editor;
    atNumber(literalAt(editor.state));
    const unfollow = useFunctions.subscribe(() => takeOver(editor, path));
    return () => {
      unfollow();
      atNumber(null);
      kept.set(path, editor.state);
      editor.destroy();
    };
  }, []);
  useEffect(() => {
    view.current?.dispatch({ effects: access.reconfigure(accessOf(readOnly)) });
  }, [readOnly]);
  useEffect(() => {
    const state = view.current?.state;
    if (state) view.current?.dispatch(setDiagnostics(state, diagnosticsOf(findings, state.doc)));
  }, [findings]);
  const asked = usePlace((state) => state.asked);
  useEffect(() => {
    if (!asked || !view.current || !sameFile(asked.file, file.path)) return;
    showLine(view.current, asked.line);
    usePlace.setState({ asked: null });
  }, [asked, file.path]);
  return <div ref={host} className="editor" />;
}

function openEditor(parent: HTMLElement, file: SourceFile, readOnly: boolean): EditorView {
  const doc = textOf(useFunctions.getState(), file.path);
  const state = kept.get(file.path) ?? EditorState.create({ doc, extensions: editing(file, readOnly) });
  const view = new EditorView({ parent, state });
  takeOver(view, file.path);
  return view;
}

/** Shows what the store has, when it changed other than by this editor. */
function takeOver(view: EditorView, path: string): void {
  const text = textOf(useFunctions.getState(), path);
  const shown = view.state.doc.toString();
  if (text !== shown) view.dispatch({ changes: difference(shown, text) });
}

function showLine(view: EditorView, line: number): void {
  const { from } = view.state.doc.line(Math.min(Math.max(line, 1), view.state.doc.lines));
  view.dispatch({
    selection: { anchor: from },
    effects: EditorView.scrollIntoView(from, { y: "center" }),
  });
  view.focus();
}
