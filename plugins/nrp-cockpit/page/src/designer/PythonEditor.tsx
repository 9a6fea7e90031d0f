import { acceptCompletion, autocompletion, type Completion, closeCompletion } from "@codemirror/autocomplete";
import { defaultKeymap, history, historyKeymap } from "@codemirror/commands";
import { python } from "@codemirror/lang-python";
import { indentUnit } from "@codemirror/language";
import { EditorState, Prec } from "@codemirror/state";
import { EditorView, keymap, lineNumbers, placeholder } from "@codemirror/view";
import { useEffect, useRef } from "react";
import { completing } from "../functions/editor/completion";
import { theme } from "../functions/editor/theme";
import { words } from "./store";

interface EditorProps {
  path: string;
  label: string;
  text: string;
  /** Whether it is a whole function, and not one expression in one line. */
  whole?: boolean;
  /** Called when one leaves the text, or presses Enter in an expression. */
  onWrite: (text: string) => void;
}

const wordsAt = (path: string) => async (): Promise<readonly Completion[]> =>
  (await words(path))?.words ?? [];

const oneLine = EditorState.transactionFilter.of((change) => (change.newDoc.lines > 1 ? [] : change));

/** An expression in one line of Python, or a function of many, with the names that the function knows. */
export function PythonEditor({ path, label, text, whole = false, onWrite }: EditorProps) {
  const host = useRef<HTMLDivElement>(null);
  const view = useRef<EditorView | null>(null);
  const write = useRef(onWrite);
  useEffect(() => {
    write.current = onWrite;
  });
  const first = useRef(text);
  const known = useRef(text); // to the server, or soon: anything else was typed since
  useEffect(() => {
    const leave = ({ state }: EditorView) => {
      known.current = state.doc.toString();
      write.current(known.current);
      return true;
    };
    const editor = new EditorView({
      parent: host.current as HTMLElement,
      state: EditorState.create({
        doc: first.current,
        extensions: [
          autocompletion({ icons: false, override: [completing(wordsAt(path))] }),
          Prec.high(
            keymap.of([
              { key: "Tab", run: acceptCompletion },
              { key: whole ? "Ctrl-Enter" : "Enter", run: leave },
            ]),
          ),
          history(),
          keymap.of([...defaultKeymap, ...historyKeymap]),
          python(),
          theme,
          whole ? [lineNumbers(), indentUnit.of("    ")] : [oneLine, EditorView.lineWrapping],
          placeholder("not written"),
          EditorView.contentAttributes.of({ "aria-label": label }),
          EditorView.domEventHandlers({
            blur: (_event, shown) => {
              closeCompletion(shown); // also names that are still asked for
              leave(shown);
            },
          }),
        ],
      }),
    });
    view.current = editor;
    return () => {
      view.current = null;
      editor.destroy();
    };
  }, [path, label, whole]);
  useEffect(() => {
    const { doc } = view.current?.state ?? EditorState.create();
    const isTyped = doc.toString() !== known.current;
    known.current = text;
    if (!isTyped && doc.toString() !== text)
      view.current?.dispatch({ changes: { from: 0, to: doc.length, insert: text } });
  }, [text]);
  return <div ref={host} className={`input form-python ${whole ? "is-whole" : ""}`} />;
}
