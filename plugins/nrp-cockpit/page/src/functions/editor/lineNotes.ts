import { type Diagnostic, forEachDiagnostic, setDiagnosticsEffect } from "@codemirror/lint";
import type { EditorState, Range } from "@codemirror/state";
import {
  Decoration,
  type DecorationSet,
  type EditorView,
  ViewPlugin,
  type ViewUpdate,
  WidgetType,
} from "@codemirror/view";

/** The message of a finding behind the end of its line, so that it is read without a pointer. */
class LineNote extends WidgetType {
  constructor(
    private readonly message: string,
    private readonly severity: Diagnostic["severity"],
  ) {
    super();
  }

  override eq(other: LineNote): boolean {
    return other.message === this.message && other.severity === this.severity;
  }

  override toDOM(): HTMLElement {
    const note = document.createElement("span");
    note.className = `cm-lineNote cm-lineNote-${this.severity}`;
    note.textContent = this.message;
    return note;
  }
}

function notesOf(state: EditorState): DecorationSet {
  const notes: Range<Decoration>[] = [];
  forEachDiagnostic(state, ({ message, severity }, from) => {
    const widget = new LineNote(message, severity);
    notes.push(Decoration.widget({ widget, side: 1 }).range(state.doc.lineAt(from).to));
  });
  return Decoration.set(notes, true);
}

const changesFindings = ({ transactions }: ViewUpdate) =>
  transactions.some(({ effects }) => effects.some((effect) => effect.is(setDiagnosticsEffect)));

/** Writes each finding behind its line. */
export const lineNotes = ViewPlugin.fromClass(
  class {
    notes: DecorationSet;

    constructor(view: EditorView) {
      this.notes = notesOf(view.state);
    }

    update(update: ViewUpdate): void {
      if (update.docChanged || changesFindings(update)) this.notes = notesOf(update.state);
    }
  },
  { decorations: ({ notes }) => notes },
);
