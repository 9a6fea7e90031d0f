import { create } from "zustand";
import { command } from "../state/commands";
import { notify } from "../state/notices";
import { useRun } from "../state/run";
import { type Trace, useTraces } from "../state/traces";
import { defaultTree, moveBorder, type Node, type PanelId, type Path, type Split, swapPanels } from "./tree";

interface Layout {
  tree: Node;
}

export const useLayout = create<Layout>(() => ({ tree: defaultTree }));

const SAVE_AFTER_MS = 500;
let timer = 0;

/** Saves beside the experiment, shortly after the last change. A viewer who may not save keeps it for the visit. */
function saveSoon(): void {
  if (!useRun.getState().experiment?.may_steer) return;
  window.clearTimeout(timer);
  timer = window.setTimeout(() => {
    const layout = { version: 1, tree: useLayout.getState().tree, traces: useTraces.getState().traces };
    void command("layout/save", { layout });
  }, SAVE_AFTER_MS);
}

function change(tree: Node): void {
  useLayout.setState({ tree });
  saveSoon();
}

export const resize = (path: Path, index: number, share: number): void =>
  change(moveBorder(useLayout.getState().tree, path, index, share));
export const swap = (a: PanelId, b: PanelId): void => change(swapPanels(useLayout.getState().tree, a, b));
export const resetLayout = (): void => change(defaultTree);

let loaded = false;

interface Saved {
  layout?: { tree: Split; traces: readonly Trace[] };
  problem?: string;
}

/** Takes over the layout that is saved beside the experiment, once; the server has checked it. */
export async function loadLayout(): Promise<void> {
  if (loaded) return;
  loaded = true;
  const { layout, problem } = (await command<Saved>("layout/load")) ?? {};
  if (problem) notify(problem, "bad");
  if (layout) {
    useLayout.setState({ tree: layout.tree });
    useTraces.setState({ traces: layout.traces });
  }
  useTraces.subscribe(({ chosen }) => chosen && saveSoon());
}
