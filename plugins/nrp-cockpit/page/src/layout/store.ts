import { create } from "zustand";
import { firstTraces } from "../plots/groups";
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

const layoutNow = () => ({
  version: 1,
  tree: useLayout.getState().tree,
  traces: useTraces.getState().traces,
});

/** Saves for the user, shortly after the last change. A viewer who may not save keeps it for the visit. */
function saveSoon(): void {
  if (!useRun.getState().experiment?.may_steer) return;
  window.clearTimeout(timer);
  timer = window.setTimeout(() => void command("layout/save", { layout: layoutNow() }), SAVE_AFTER_MS);
}

function change(tree: Node): void {
  useLayout.setState({ tree });
  saveSoon();
}

export const resize = (path: Path, index: number, share: number): void =>
  change(moveBorder(useLayout.getState().tree, path, index, share));
export const swap = (a: PanelId, b: PanelId): void => change(swapPanels(useLayout.getState().tree, a, b));

let loaded = false;

interface Saved {
  layout?: { tree: Split; traces: readonly Trace[] };
  problem?: string;
}

/** Takes over the user's layout, or the preset of the experiment, once; the server has checked it. */
export async function loadLayout(): Promise<void> {
  if (loaded) return;
  loaded = true;
  take((await command<Saved>("layout/load")) ?? {});
  useTraces.subscribe(({ chosen }) => chosen && saveSoon());
}

function take({ layout, problem }: Saved): void {
  if (problem) notify(problem, "bad");
  if (layout) {
    useLayout.setState({ tree: layout.tree });
    useTraces.setState({ traces: layout.traces, chosen: false });
  }
}

/** Goes back to the preset of the experiment, or to the usual layout if it has none. */
export async function resetLayout(): Promise<void> {
  window.clearTimeout(timer);
  const { experiment } = useRun.getState();
  const saved = experiment?.may_steer ? await command<Saved>("layout/reset") : {};
  if (!saved) return;
  useLayout.setState({ tree: defaultTree });
  useTraces.setState({ traces: experiment ? firstTraces(experiment) : [], chosen: false });
  take(saved);
}

/** Makes the layout of now what everybody gets with this experiment. */
export async function presetLayout(): Promise<void> {
  window.clearTimeout(timer);
  if (await command("layout/preset", { layout: layoutNow() }))
    notify("Everybody with this experiment gets this layout, unless they have their own.");
}
