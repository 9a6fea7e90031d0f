import { autocompletion } from "@codemirror/autocomplete";
import { indentWithTab } from "@codemirror/commands";
import { python } from "@codemirror/lang-python";
import { xml } from "@codemirror/lang-xml";
import { indentUnit } from "@codemirror/language";
import { lintGutter } from "@codemirror/lint";
import { Compartment, EditorState, type Extension, Prec } from "@codemirror/state";
import { EditorView, keymap } from "@codemirror/view";
import { basicSetup } from "codemirror";
import { baseName } from "../../state/paths";
import type { SourceFile } from "../../state/types";
import { literalAt } from "../literal";
import { apply, atNumber, edit, save } from "../store";
import { completing } from "./completion";
import { fixLine, lineNotes } from "./lineNotes";
import { theme } from "./theme";
import { words } from "./words";

/** Whether the text may be edited: `access.reconfigure(accessOf(...))`. */
export const access = new Compartment();
export const accessOf = (readOnly: boolean): Extension => EditorState.readOnly.of(readOnly);

const languageOf = ({ language }: SourceFile): Extension => (language === "python" ? python() : xml());

const applyAll = ({ state }: EditorView) => {
  if (!state.readOnly) void apply();
  return true;
};

const saveShown = ({ state }: EditorView, { path, editable }: SourceFile) => {
  if (editable && !state.readOnly) void save(path, state.doc.toString());
  return true;
};

const keysOf = (file: SourceFile): Extension =>
  Prec.highest(
    keymap.of([
      { key: "Mod-Enter", run: applyAll },
      { key: "Mod-.", run: fixLine },
      { key: "Mod-s", preventDefault: true, run: (view) => saveShown(view, file) },
    ]),
  );

/** What both the editor and the comparison need to show a file. */
export const showing = (file: SourceFile): Extension => [basicSetup, languageOf(file), theme];

/** One list for good: completion takes another function for another source, and would begin anew with each key. */
const experimentWords = [{ autocomplete: completing(words) }];

/** All that the editor of a file does; each change goes to the drafts at once. */
export const editing = (file: SourceFile, readOnly: boolean): Extension => [
  keysOf(file),
  showing(file),
  keymap.of([indentWithTab]),
  indentUnit.of(file.language === "python" ? "    " : "  "),
  lintGutter(),
  lineNotes,
  autocompletion({ icons: false }),
  EditorState.languageData.of(() => experimentWords),
  access.of(accessOf(readOnly)),
  EditorView.contentAttributes.of({ "aria-label": `Source of ${baseName(file.path)}` }),
  EditorView.updateListener.of(({ docChanged, selectionSet, state }) => {
    if (docChanged) edit(file.path, state.doc.toString());
    if (docChanged || selectionSet) atNumber(literalAt(state));
  }),
];
