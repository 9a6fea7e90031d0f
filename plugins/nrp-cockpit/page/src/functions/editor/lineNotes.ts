import { type Action, type Diagnostic, forEachDiagnostic, setDiagnosticsEffect } from "@codemirror/lint";
import type { EditorState, Range } from "@codemirror/state";
import {
  Decoration,
  type DecorationSet,
  type EditorView,
  ViewPlugin,
  type ViewUpdate,
  WidgetType,
} from "@codemirror/view";

/** The message of a finding behind the end of its line, so that it is read without a pointer, and a click to mend it. */
class LineNote extends WidgetType {
  constructor(
    private readonly message: string,
    private readonly severity: Diagnostic["severity"],
    private readonly fix: Action | undefined,
  ) {
    super();
  }

  override eq(other: LineNote): boolean {
    const same = other.message === this.message && other.severity === this.severity;
    return same && other.fix?.name === this.fix?.name;
  }

  override ignoreEvent(): boolean {
    return true; // a click belongs to the button, not to the text
  }

  override toDOM(view: EditorView): HTMLElement {
    const note = document.createElement("span");
    note.className = `cm-lineNote cm-lineNote-${this.severity}`;
    note.textContent = this.message;
    if (this.fix) note.append(fixButton(view, this.fix));
    return note;
  }
}

function fixButton(view: EditorView, { name, apply }: Action): HTMLElement {
  const button = document.createElement("button");
  button.type = "button";
  button.className = "cm-lineFix";
  button.textContent = name;
  button.tabIndex = -1; // Ctrl . does the same where the cursor is
  button.addEventListener("mousedown", (event) => event.preventDefault());
  button.addEventListener("click", () => apply(view, 0, 0));
  return button;
}

/** Mends the line of the cursor, as far as a finding says how. */
export function fixLine(view: EditorView): boolean {
  const { state } = view;
  const here = state.doc.lineAt(state.selection.main.head).number;
  const fixes: Action[] = [];
  forEachDiagnostic(state, ({ actions }, from) => {
    if (state.doc.lineAt(from).number === here) fixes.push(...(actions ?? []));
  });
  fixes[0]?.apply(view, 0, 0);
  return true;
}

function notesOf(state: EditorState): DecorationSet {
  const notes: Range<Decoration>[] = [];
  forEachDiagnostic(state, ({ message, severity, actions }, from) => {
    const widget = new LineNote(message, severity, actions?.[0]);
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
