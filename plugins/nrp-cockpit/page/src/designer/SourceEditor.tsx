import { python } from "@codemirror/lang-python";
import { xml } from "@codemirror/lang-xml";
import { setDiagnostics } from "@codemirror/lint";
import { EditorState, type Extension, StateEffect, StateField } from "@codemirror/state";
import { Decoration, type DecorationSet, EditorView } from "@codemirror/view";
import { basicSetup } from "codemirror";
import { useEffect, useRef } from "react";
import { theme } from "../functions/editor/theme";
import { Empty } from "../ui/Panel";
import { write } from "./store";

interface EditorProps {
  language: "xml" | "python";
  text: string;
  readOnly: boolean;
  /** Why there is no text. */
  missing: string | null;
  /** The lines of what is selected. */
  lines: ReadonlySet<number>;
  onError: (error: string | null) => void;
}

const TYPED_MS = 400;

const mark = StateEffect.define<ReadonlySet<number>>();
const line = Decoration.line({ class: "design-line" });
const marked = StateField.define<DecorationSet>({
  create: () => Decoration.none,
  update: (before, { effects, changes, state }) => {
    const now = effects.find((effect) => effect.is(mark))?.value as ReadonlySet<number> | undefined;
    if (!now) return before.map(changes);
    const there = [...now].filter((one) => one <= state.doc.lines).toSorted((a, b) => a - b);
    return Decoration.set(there.map((one) => line.range(state.doc.line(one).from)));
  },
  provide: (field) => EditorView.decorations.from(field),
});

/** A text of the whole model: what is typed goes to the drawing once it is right. */
export function SourceEditor({ language, text, readOnly, missing, lines, onError }: EditorProps) {
  const host = useRef<HTMLDivElement>(null);
  const view = useRef<EditorView | null>(null);
  const shown = useRef(text);
  useEffect(() => {
    let timer = 0;
    const take = async (editor: EditorView) => {
      const typed = editor.state.doc.toString();
      const answer = await write(language, typed);
      if (!answer || view.current !== editor || editor.state.doc.toString() !== typed) return;
      onError(answer.error && `${answer.line ? `line ${answer.line}: ` : ""}${answer.error}`);
      const at = editor.state.doc.line(Math.min(answer.line ?? 1, editor.state.doc.lines));
      const found = answer.error
        ? [{ from: at.from, to: at.to, severity: "error" as const, message: answer.error }]
        : [];
      editor.dispatch(setDiagnostics(editor.state, found));
    };
    const typing = EditorView.updateListener.of(({ docChanged, transactions, view: editor }) => {
      if (!docChanged || !transactions.some((one) => one.isUserEvent("input") || one.isUserEvent("delete")))
        return;
      window.clearTimeout(timer);
      timer = window.setTimeout(() => void take(editor), TYPED_MS);
    });
    const leaving = EditorView.domEventHandlers({
      blur: (_event, editor) => follow(editor, shown.current),
    });
    const editor = new EditorView({
      parent: host.current as HTMLElement,
      doc: shown.current,
      extensions: [
        basicSetup,
        language === "xml" ? xml() : python(),
        theme,
        marked,
        typing,
        leaving,
        EditorState.readOnly.of(readOnly),
        EditorView.contentAttributes.of({ "aria-label": language === "xml" ? "XML" : "Python" }),
      ] satisfies Extension[],
    });
    view.current = editor;
    onError(null);
    return () => {
      window.clearTimeout(timer);
      view.current = null;
      editor.destroy();
    };
  }, [language, readOnly, onError]);
  useEffect(() => {
    shown.current = text;
    if (view.current && !view.current.hasFocus) follow(view.current, text);
  }, [text]);
  useEffect(() => {
    const editor = view.current;
    if (!editor) return;
    const first = Math.min(...lines, editor.state.doc.lines);
    const from = editor.state.doc.line(Math.max(first, 1)).from;
    const scroll =
      lines.size > 0 && !editor.hasFocus
        ? [EditorView.scrollIntoView(from, { y: "start", yMargin: 24 })]
        : [];
    editor.dispatch({ effects: [mark.of(lines), ...scroll] });
  }, [lines]);
  return (
    <>
      {missing && (
        <div className="source-missing">
          <Empty>There is no Python yet: {missing}</Empty>
        </div>
      )}
      <div ref={host} className="editor" hidden={missing !== null} />
    </>
  );
}

/** Shows the text of the server, unless a mistake in what was typed would be lost with it. */
function follow(editor: EditorView, text: string): void {
  const { doc } = editor.state;
  if (text !== doc.toString()) editor.dispatch({ changes: { from: 0, to: doc.length, insert: text } });
}
