import { create } from "zustand";
import { wire } from "../wire";
import { command } from "./commands";

/** Something that can be opened. */
export interface Entry {
  kind: "experiment" | "recording" | "sweep";
  name: string;
  /** Whether it is installed; otherwise it is in the folder. */
  installed: boolean;
  text: string;
  engines: string[];
  /** Why it cannot be read; empty if it can. */
  error: string;
  /** The key of its picture, equal for entries that look the same; empty: it has none. */
  picture: string;
}

interface Start {
  folder: string;
  /** null: one of them is open. */
  entries: Entry[] | null;
}

interface State {
  /** Whether the page shows what can be opened. */
  isOpen: boolean;
  /** null: the server has no start page, or did not tell of it yet. */
  start: Start | null;
  /** The entry that is being opened. */
  opening: string | null;
  /** Whether the user agreed that the files of the experiments in the folder are read for their pictures. */
  readsFiles: boolean;
}

export const useStart = create<State>(() => ({
  isOpen: window.location.hash === "#/start",
  start: null,
  opening: null,
  readsFiles: false,
}));

/** Fills the store from the wire, for as long as the page lives. */
export function followStart(): void {
  wire.subscribe<Start>("/cockpit/start", (start) =>
    useStart.setState({ isOpen: start.entries !== null, start }),
  );
}

/** Opens an entry; then the server has all its pages load anew. */
export async function open(name: string): Promise<void> {
  useStart.setState({ opening: name });
  await command("start/open", { name });
  useStart.setState({ opening: null });
}

export const look = () => command("start/look");
/** Closes what is open; then the server has all its pages load anew. */
export const leave = () => command("start/leave");
