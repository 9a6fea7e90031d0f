import { branch, playOrPause, step, stepBack, takeSnapshot, toggleRecording } from "../state/commands";
import { select } from "../state/selection";
import { openView, setFull, setHelp, useView, VIEWS } from "../state/view";
import { focusNextPanel, fullSizeOfFocused } from "./panels";

export interface KeyEntry {
  /** As `keyOf` writes a key press: modifiers in the order Ctrl, Shift, then the key. */
  keys: readonly string[];
  /** As the help shows it. */
  shown: string;
  group: "Run" | "View" | "Panels" | "Scene" | "Functions" | "Designer";
  does: string;
  /** Whether it changes a run, which a recording does not allow. */
  changes: boolean;
  /** Null: the room that has the focus acts on it itself. */
  run: ((event: KeyboardEvent) => void) | null;
}

const entry = (
  group: KeyEntry["group"],
  keys: string | readonly string[],
  shown: string,
  does: string,
  run: KeyEntry["run"] = null,
  changes = group === "Functions" || group === "Designer",
): KeyEntry => ({ group, keys: typeof keys === "string" ? [keys] : keys, shown, does, run, changes });

const press = (selector: string) => document.querySelector<HTMLElement>(selector)?.click();

const openNumbered = ({ key }: KeyboardEvent) => {
  const view = VIEWS[Number(key) - 1];
  if (view) openView(view);
};

const branchHere = () => {
  openView("compare");
  void branch({ t_s: null });
};

const leave = () => (useView.getState().full ? setFull(null) : select(null));

/** Every key of the page: what acts on it, and what the help says. */
export const keymap: readonly KeyEntry[] = [
  entry("Run", " ", "Space", "Play or pause", () => void playOrPause()),
  entry("Run", ",", ",", "Step back", () => void stepBack()),
  entry("Run", ".", ".", "Step", () => void step()),
  entry("Run", "Shift+R", "Shift R", "Reset menu", () => press('[data-key="reset"]')),
  entry("Run", "s", "S", "Take a snapshot", () => void takeSnapshot(), true),
  entry("Run", "b", "B", "Branch: a second future next to this one", branchHere, true),
  entry("Run", "r", "R", "Start or stop recording", toggleRecording, true),
  entry("View", ["1", "2", "3", "4"], "1 to 4", "Open a view", openNumbered),
  entry("View", "?", "?", "This help", () => setHelp(true)),
  entry("Panels", "F6", "F6, Shift F6", "Next panel, previous panel", () => focusNextPanel(1)),
  entry("Panels", "Shift+F6", "arrows", "Move inside a panel", () => focusNextPanel(-1)),
  entry("Panels", "Enter", "Enter", "Show the panel at full size", fullSizeOfFocused),
  entry("Panels", "Escape", "Esc", "Leave full size, clear the selection", leave),
  entry("Scene", "f", "F", "Fit the selected body, or the room", () => press('[data-key="fit"]')),
  entry("Scene", [], "← → ↑ ↓", "Orbit"),
  entry("Scene", [], "Shift ← → ↑ ↓", "Pan"),
  entry("Scene", [], "+ −", "Zoom"),
  entry("Scene", [], "← → ↑ ↓ in Edit", "Move the selected body", null, true),
  entry("Scene", [], "Shift ← → in Edit", "Turn the selected body", null, true),
  entry("Functions", [], "Ctrl Enter", "Apply the changes"),
  entry("Functions", [], "Ctrl Space", "Complete the word"),
  entry("Functions", [], "F8", "Next finding"),
  entry("Functions", [], "Ctrl .", "Quick fix for the line"),
  entry("Functions", [], "Ctrl Z, Ctrl Y", "Undo, redo"),
  entry("Functions", [], "Esc, then Tab", "Leave the editor"),
  entry("Designer", [], "Ctrl Z, Ctrl Y", "Undo, redo"),
  entry("Designer", [], "Ctrl D", "Copy"),
  entry("Designer", [], "Delete", "Remove"),
  entry("Designer", [], "Ctrl S", "Save"),
  entry("Designer", [], "Ctrl Shift Enter", "Run"),
];
