import { type RefObject, useContext, useEffect, useState } from "react";
import { PanelContext } from "../state/panelContext";
import { waitNoLonger } from "../state/picture";
import { useSelection } from "../state/selection";
import { useView } from "../state/view";
import { Viewer } from "./viewer";

/** The viewer of a canvas, for as long as it is mounted; a sentence if the browser cannot draw it. */
export function useViewer(canvas: RefObject<HTMLCanvasElement | null>): Viewer | string | null {
  const { id } = useContext(PanelContext);
  const [viewer, setViewer] = useState<Viewer | string | null>(null);
  useEffect(() => {
    if (!canvas.current) return;
    let made: Viewer | null = null;
    try {
      made = new Viewer(canvas.current, id);
      setViewer(made);
    } catch {
      waitNoLonger();
      setViewer("The scene needs WebGL, which this browser does not support.");
    }
    return () => {
      made?.dispose();
      setViewer(null);
    };
  }, [canvas, id]);
  const dark = useView((state) => state.dark);
  const selected = useSelection(({ selected: one }) => (one?.kind === "body" ? one.name : null));
  // biome-ignore lint/correctness/useExhaustiveDependencies: the colours are read anew when the theme changes
  useEffect(() => {
    if (viewer instanceof Viewer) viewer.style();
  }, [viewer, dark]);
  useEffect(() => {
    if (viewer instanceof Viewer) viewer.select(selected);
  }, [viewer, selected]);
  return viewer;
}
