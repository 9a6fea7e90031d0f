import type { Completion } from "@codemirror/autocomplete";
import { create } from "zustand";
import { notify } from "../state/notices";
import { openView } from "../state/view";
import { wire } from "../wire";
import type { DesignState, Metamodel, PlacedFinding } from "./types";

interface Design {
  state: DesignState | null;
  /** The classes of what is drawn. */
  metamodel: Metamodel | null;
  /** Those of both kinds of drawings. */
  described: Record<DesignState["kind"], Metamodel> | null;
  /** The path of the part, or the id of the box, that is shown in the form; empty: the whole model. */
  selected: string;
  /** Whether the selected part was made just now, so that its name is what one types next. */
  isNew: boolean;
  findings: readonly PlacedFinding[];
  /** While a wire is drawn: for each end, why it does not fit; null: it fits. */
  refusals: Readonly<Record<string, string | null>> | null;
  /** A wire that was refused: why, and where it was dropped. */
  refused: { reason: string; x: number; y: number } | null;
}

export const useDesign = create<Design>(() => ({
  state: null,
  metamodel: null,
  described: null,
  selected: "",
  isNew: false,
  findings: [],
  refusals: null,
  refused: null,
}));

const { getState: get, setState: set } = useDesign;
const TOPIC = "/cockpit/designer";
const CHECK_AFTER_MS = 250;
const REFUSED_MS = 6000;

/** Requests are made one after another: a name that was just typed counts for the wire that follows. */
let last: Promise<unknown> = Promise.resolve();

function ask<T>(name: string, request: object = {}): Promise<T> {
  const answer = last.then(() => wire.call<T>(`/cockpit/designer/${name}`, request));
  last = answer.catch(() => undefined);
  return answer;
}

/** Asks without waiting for the changes that were asked for. */
const look = <T>(name: string, request: object = {}): Promise<T | null> =>
  wire.call<T>(`/cockpit/designer/${name}`, request).catch(() => null);

const sentence = (error: unknown) => (error instanceof Error ? error.message : String(error));

/** Asks for something; a failure becomes a notice. */
export async function send<T = object>(name: string, request: object = {}): Promise<T | null> {
  try {
    return await ask<T>(name, request);
  } catch (error) {
    notify(sentence(error), "bad");
    return null;
  }
}

/** Changes the model by a command of the server; returns why it was refused, or undefined. */
export async function change(command: string, args: object): Promise<string | undefined> {
  try {
    const { selected } = await ask<{ selected: string | null }>("do", { command, arguments: args });
    if (selected !== null) set({ selected, isNew: command === "add" || command === "connect" });
    return undefined;
  } catch (error) {
    return sentence(error);
  }
}

/** Like `change`, for buttons: why it was refused becomes a notice. */
export async function act(command: string, args: object): Promise<void> {
  const reason = await change(command, args);
  if (reason) notify(reason, "bad");
}

/** Like `act`, inside a form, which stays. */
export async function actHere(command: string, args: object): Promise<void> {
  const { selected } = get();
  await act(command, args);
  select(selected);
}

/** Notes that the name of what was made has the focus. */
export const named = (): void => set({ isNew: false });

export const select = (selected: string): void => set({ selected, isNew: false });
export const undo = () => send("undo");
export const redo = () => send("redo");
export const arrange = () => send("arrange");
export const place = (box: string, x: number, y: number) => send("place", { box, x, y });
/** Shows the drawing of the functions, that of the brain, or a new one of a brain. */
export const turn = (to: "functions" | "brain" | "new brain") => send("turn", { to }).then(() => select(""));
export const show = (topic: string) => send("show", { topic });
export const open = (file: string) => send("open", { file }).then(() => select(""));
export const write = (language: string, text: string) =>
  send<{ error: string | null; line: number | null }>("write", { language, text });

export async function save(): Promise<void> {
  const state = get().state;
  if ((await send("save")) && state) notify(`Saved ${state.file}.`);
}

/** Lets the run begin again with this model, and shows it. */
export async function run(): Promise<void> {
  const answer = await send<{ applied: boolean; findings: PlacedFinding[] }>("run");
  if (!answer) return;
  set({ findings: answer.findings });
  if (answer.applied) openView("cockpit");
  else notify(`The model cannot run yet: ${answer.findings[0]?.summary ?? ""}`, "bad");
}

/** For each end of a wire, why it does not fit one; null: it fits. */
export const fits = (source: string) => look<{ refusals: Record<string, string | null> }>("fits", { source });

/** What an editor of expressions proposes. */
export const words = (path: string) => look<{ words: Completion[] }>("words", { path });

/** Drags do not take the focus, so what was typed into a field would be lost with its form. */
export function leaveField(): void {
  if (document.activeElement instanceof HTMLElement) document.activeElement.blur();
}

/** Asks which ends fit a wire that begins here. */
export async function beginWire(source: string): Promise<void> {
  leaveField();
  set({ refused: null });
  const answer = await fits(source);
  if (answer) set({ refusals: answer.refusals });
}

/** Ends a wire, at an end or nowhere; the reason of a refusal is shown where it was dropped. */
export async function endWire(source: string, target: string | null, x: number, y: number): Promise<void> {
  set({ refusals: null });
  if (target === null || target === source) return;
  const reason = await change("connect", { source, target });
  if (!reason) return;
  const refused = { reason, x, y };
  set({ refused });
  window.setTimeout(() => get().refused === refused && set({ refused: null }), REFUSED_MS);
}

let timer = 0;
let checking = false;

/** Checks the model, which takes a second: one check at a time, and of the last state in the end. */
async function check(): Promise<void> {
  if (checking) return;
  checking = true;
  const answer = await look<{ revision: number; findings: PlacedFinding[] }>("check");
  checking = false;
  if (!answer) return;
  if (answer.revision === get().state?.revision) set({ findings: answer.findings });
  else checkSoon();
}

function checkSoon(): void {
  window.clearTimeout(timer);
  timer = window.setTimeout(() => void check(), CHECK_AFTER_MS);
}

function take(state: DesignState): void {
  const { state: before, described } = get();
  if (before?.file !== state.file) set({ findings: [] });
  set({ state, metamodel: described?.[state.kind] ?? null });
  checkSoon();
}

/** Follows the model while the designer is open; the server sends it to every page after each change. */
export function follow(): () => void {
  const unhear = wire.subscribe<DesignState>(TOPIC, take);
  void send<NonNullable<Design["described"]>>("describe").then((described) => {
    const { state } = get();
    if (described) set({ described, metamodel: state ? described[state.kind] : null });
  });
  return () => {
    window.clearTimeout(timer);
    unhear();
  };
}
