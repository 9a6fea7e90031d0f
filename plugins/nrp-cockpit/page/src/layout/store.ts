import { create } from "zustand";
import { firstTraces } from "../plots/groups";
import { command } from "../state/commands";
import { notify } from "../state/notices";
import { usePanelChoices } from "../state/panelChoices";
import { type Kind, kindOf, type PanelId } from "../state/panels";
import { useRun } from "../state/run";
import { type Trace, useTraces } from "../state/traces";
import {
  append,
  defaultTree,
  freeId,
  moveBorder,
  type Path,
  panelsOf,
  putBeside,
  replace,
  type Side,
  type Split,
  swapPanels,
  without,
} from "./tree";

interface Layout {
  tree: Split;
}

export const useLayout = create<Layout>(() => ({ tree: defaultTree }));

const SAVE_AFTER_MS = 500;
let timer = 0;

const layoutNow = () => ({
  version: 1,
  tree: useLayout.getState().tree,
  traces: useTraces.getState().traces,
  choices: usePanelChoices.getState().choices,
});

/** Saves for the user, shortly after the last change. A viewer who may not save keeps it for the visit. */
function saveSoon(): void {
  if (!useRun.getState().experiment?.may_steer) return;
  window.clearTimeout(timer);
  timer = window.setTimeout(() => void command("layout/save", { layout: layoutNow() }), SAVE_AFTER_MS);
}

/** Changes the tree; what a closed panel showed is forgotten. */
function change(to: (tree: Split) => Split): void {
  const before = panelsOf(useLayout.getState().tree);
  useLayout.setState(({ tree }) => ({ tree: to(tree) }));
  const there = new Set<string>(panelsOf(useLayout.getState().tree));
  for (const id of before.filter((one) => !there.has(one))) {
    usePanelChoices.setState(({ choices: { [id]: _, ...choices } }) => ({ choices }));
    useTraces.setState(({ traces }) => ({ traces: traces.filter(({ panel = "traces" }) => panel !== id) }));
  }
  saveSoon();
}

export const resize = (path: Path, between: readonly [number, number], share: number): void =>
  change((tree) => moveBorder(tree, path, between, share));
export const swap = (a: PanelId, b: PanelId): void => change((tree) => swapPanels(tree, a, b));
/** Moves a panel to one side of another. */
export const moveTo = (moved: PanelId, id: PanelId, side: Side): void =>
  change((tree) => putBeside(without(tree, moved), id, side, moved));
/** Opens another panel of the same kind beside one. */
export const split = (id: PanelId, side: Side): void =>
  change((tree) => putBeside(tree, id, side, freeId(tree, kindOf(id))));
export const become = (id: PanelId, kind: Kind): void =>
  change((tree) => replace(tree, id, freeId(tree, kind)));
export const close = (id: PanelId): void => change((tree) => without(tree, id));
export const add = (kind: Kind): void => change((tree) => append(tree, freeId(tree, kind)));

let loaded = false;

interface Saved {
  layout?: { tree: Split; traces: readonly Trace[]; choices?: Record<string, string> };
  problem?: string;
}

/** Takes over the user's layout, or the preset of the experiment, once; the server has checked it. */
export async function loadLayout(): Promise<void> {
  if (loaded) return;
  loaded = true;
  take((await command<Saved>("layout/load")) ?? {});
  useTraces.subscribe(({ traces, chosen }) => {
    if (!chosen) return;
    const there = new Set<string>(panelsOf(useLayout.getState().tree));
    if (!there.has("traces") && traces.some(({ panel = "traces" }) => panel === "traces")) add("traces");
    else saveSoon();
  });
  usePanelChoices.subscribe(({ chosen }) => chosen && saveSoon());
}

function take({ layout, problem }: Saved): void {
  if (problem) notify(problem, "bad");
  if (layout) {
    useLayout.setState({ tree: layout.tree });
    useTraces.setState({ traces: layout.traces, chosen: false });
    usePanelChoices.setState({ choices: layout.choices ?? {}, chosen: false });
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
  usePanelChoices.setState({ choices: {}, chosen: false });
  take(saved);
}

/** Makes the layout of now what everybody gets with this experiment. */
export async function presetLayout(): Promise<void> {
  window.clearTimeout(timer);
  if (await command("layout/preset", { layout: layoutNow() }))
    notify("Everybody with this experiment gets this layout, unless they have their own.");
}
