import { create } from "zustand";
import { useTraces } from "../state/traces";
import { wire } from "../wire";
import { defaultTree, isTree, moveBorder, type Node, type PanelId, type Path, swapPanels } from "./tree";

interface Layout {
  tree: Node;
}

export const useLayout = create<Layout>(() => ({ tree: defaultTree }));

const SAVE_AFTER_MS = 500;
let timer = 0;

/** Saves beside the experiment, shortly after the last change. A viewer who may not save keeps it for the visit. */
function saveSoon(): void {
  window.clearTimeout(timer);
  timer = window.setTimeout(() => {
    const layout = { version: 1, tree: useLayout.getState().tree, traces: useTraces.getState().traces };
    wire.call("/cockpit/layout/save", { layout }).catch(() => undefined);
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

/** Takes over the layout that is saved beside the experiment, once, if it is one that this page knows. */
export async function loadLayout(): Promise<void> {
  if (loaded) return;
  loaded = true;
  const answer = await wire
    .call<{ layout?: { tree?: unknown; traces?: unknown } }>("/cockpit/layout/load")
    .catch(() => null);
  const { tree, traces } = answer?.layout ?? {};
  if (isTree(tree)) useLayout.setState({ tree });
  if (Array.isArray(traces)) useTraces.setState({ traces });
  useTraces.subscribe(({ chosen }) => chosen && saveSoon());
}
