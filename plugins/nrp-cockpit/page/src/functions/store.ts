import { create } from "zustand";
import { recheckSoon } from "../parameters/recheck";
import { command } from "../state/commands";
import { notify } from "../state/notices";
import { baseName, sameFile } from "../state/paths";
import { openPlace } from "../state/place";
import { useRun } from "../state/run";
import type { Finding } from "../state/types";
import { wire } from "../wire";
import { type Literal, written } from "./literal";
import { applied, edited, following, rebased, type Sources, textOf } from "./sources";

interface FunctionsState extends Sources {
  /** The path of the file in the editor. */
  open: string | null;
  /** What the last check, or the last refused apply, found in the drafts. */
  checked: readonly Finding[];
  /** Why the drafts could not be checked or applied, if they could not. */
  problem: string | null;
  checking: boolean;
  applying: boolean;
  /** The number at the cursor of the editor. */
  literal: Literal | null;
  /** The draft that a slider made, if that was the last edit. */
  slid: string | null;
}

/** The files, the drafts and what is wrong with them; it outlives the view, so drafts do too. */
export const useFunctions = create<FunctionsState>(() => ({
  files: [],
  drafts: {},
  bases: {},
  open: null,
  checked: [],
  problem: null,
  checking: false,
  applying: false,
  literal: null,
  slid: null,
}));

const { getState: get, setState: set } = useFunctions;

const CHECK_AFTER_MS = 400;
let timer = 0;

/** Follows the files of the run, from the first time that the view is opened. */
function follow({ functions }: Pick<ReturnType<typeof useRun.getState>, "functions">): void {
  if (!functions) return;
  const before = get();
  const sources = following(before, functions.files);
  if (sources === before) return;
  const known = functions.files.some(({ path }) => path === before.open);
  set({ ...sources, open: known ? before.open : (functions.files[0]?.path ?? null) });
  if (sources.drafts !== before.drafts) checkSoon();
}
follow(useRun.getState());
useRun.subscribe(follow);

export const openFile = (open: string): void => set({ open });

export function edit(path: string, text: string): void {
  set(edited(get(), path, text));
  checkSoon();
}

function checkSoon(): void {
  window.clearTimeout(timer);
  timer = window.setTimeout(() => void check(), CHECK_AFTER_MS);
}

const sentence = (error: unknown) => (error instanceof Error ? error.message : String(error));

/** Lets the server check the drafts; nothing is run. One check at a time: one that is out of date is made again. */
async function check(): Promise<void> {
  const { drafts, checking } = get();
  if (checking) return;
  if (Object.keys(drafts).length === 0) return set({ checked: [], problem: null });
  set({ checking: true });
  const found = await findingsIn(drafts);
  set({ checking: false });
  if (get().drafts === drafts) set(found);
  else checkSoon();
}

async function findingsIn(files: Sources["drafts"]): Promise<Partial<FunctionsState>> {
  try {
    const { findings } = await wire.call<{ findings: Finding[] }>("/cockpit/functions/check", { files });
    return { checked: findings, problem: null };
  } catch (error) {
    return { problem: `Not checked: ${sentence(error)}` };
  }
}

export const atNumber = (literal: Literal | null): void => set({ literal });

/** Whether the run takes a number from a slider at once: no edit waits but one by the slider itself. */
export function isLive({ drafts, slid }: FunctionsState): boolean {
  const texts = Object.values(drafts);
  return texts.length === 0 || (texts.length === 1 && texts[0] === slid);
}

/** Writes another number in place of the one at the cursor. */
export async function setNumber(path: string, value: number): Promise<void> {
  const state = get();
  const { literal } = state;
  if (!literal || state.open !== path) return;
  const live = isLive(state);
  const text = textOf(state, path);
  const slid = text.slice(0, literal.from) + written(value, literal.whole) + text.slice(literal.to);
  edit(path, slid);
  set({ slid: live ? slid : null });
  if (live) await apply({ check: false });
}

/** What is edited while the run takes the drafts is sent after them. */
let last: Promise<void> = Promise.resolve();

/**
 * Sends all drafts to the run at once: between two steps all of them change, or none does. Without a check, which
 * halts the run for half a second, only what cannot be loaded is refused, and the check follows.
 */
export function apply({ check }: { check: boolean } = { check: true }): Promise<void> {
  last = last.then(() => applyNow(check));
  return last;
}

async function applyNow(check: boolean): Promise<void> {
  const { drafts } = get();
  if (Object.keys(drafts).length === 0) return;
  window.clearTimeout(timer);
  set({ applying: true, problem: null });
  try {
    const answer = await wire.call<{ applied: boolean; findings: Finding[] }>("/cockpit/functions/apply", {
      files: drafts,
      base: get().bases,
      check,
    });
    if (!check) recheckSoon();
    if (answer.applied) set({ ...applied(get(), drafts), checked: answer.findings });
    else refused(answer.findings, drafts);
  } catch (error) {
    set({ problem: `Not applied: ${sentence(error)}` });
  } finally {
    set({ applying: false });
  }
}

/** Shows at the line why the run did not take the drafts, unless they were edited since. */
function refused(findings: readonly Finding[], drafts: Sources["drafts"]): void {
  if (get().drafts !== drafts) {
    checkSoon();
    return;
  }
  const first = findings.find(({ weight }) => weight === "error") ?? findings[0];
  set({ checked: findings, problem: `Not applied: ${first?.summary ?? "the run refused the changes."}` });
  const file = get().files.find(({ path }) => first?.file && sameFile(path, first.file));
  if (file && first?.line) openPlace({ file: file.path, line: first.line });
}

/** Lets the drafts replace what somebody else has applied meanwhile. */
export const keepMine = (): void => set({ ...rebased(get()), problem: null });

/** Back to what runs; the editor can undo it. */
export const discard = (): void => set({ drafts: {}, bases: {}, checked: [], problem: null });

/** Lets the run have the files as they are on the disk. */
export async function revert(): Promise<void> {
  if (await command("functions/revert")) discard();
}

/** Writes the file in the editor as it is shown. */
export async function save(path: string, text: string): Promise<void> {
  const base = get().bases[path];
  const request = { files: { [path]: text }, base: base === undefined ? {} : { [path]: base } };
  if (await command("functions/save", request)) notify(`Saved ${baseName(path)}.`);
}

export const activate = (name: string, active: boolean) => command("functions/activate", { name, active });
