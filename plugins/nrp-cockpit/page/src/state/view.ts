import { create } from "zustand";
import { isPlayed } from "../wire/recording";
import { keep, kept } from "./kept";

export type View = "cockpit" | "functions" | "designer" | "compare";
/** A page with a recording in it has only the views that show a run. */
export const VIEWS: readonly View[] = isPlayed()
  ? ["cockpit", "functions"]
  : ["cockpit", "functions", "designer", "compare"];

/** Whether this page is inside another one, which compares two runs. */
export const isEmbedded = (page: Pick<Location, "search">): boolean =>
  new URLSearchParams(page.search).has("embedded");

const viewOf = (hash: string): View => VIEWS.find((view) => hash === `#/${view}`) ?? "cockpit";

interface ViewState {
  view: View;
  dark: boolean;
  help: boolean;
  /** The panel shown in full size, by its id. */
  full: string | null;
}

const THEME = "nrp-cockpit-theme";
/** The theme of the person's system, until they choose one. */
const preferred = () => (window.matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");

export const useView = create<ViewState>(() => ({
  view: viewOf(window.location.hash),
  dark: (kept(THEME) ?? preferred()) === "dark",
  help: false,
  full: null,
}));

export function openView(view: View): void {
  window.location.hash = `#/${view}`;
}

export function toggleTheme(): void {
  const dark = !useView.getState().dark;
  keep(THEME, dark ? "dark" : "light");
  useView.setState({ dark });
}

export const setHelp = (help: boolean): void => useView.setState({ help });
export const setFull = (full: string | null): void => useView.setState({ full });

/** Keeps the page in step with the address and the theme. */
export function followView(): void {
  const paint = ({ dark }: ViewState) => {
    document.documentElement.className = dark ? "theme-dark" : "theme-light";
  };
  paint(useView.getState());
  useView.subscribe(paint);
  window.addEventListener("storage", ({ key, newValue }) => {
    if (key === THEME) useView.setState({ dark: newValue === "dark" }); // chosen in the page around this one
  });
  window.addEventListener("hashchange", () =>
    useView.setState({ view: viewOf(window.location.hash), full: null }),
  );
}
