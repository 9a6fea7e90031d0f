import { useEffect } from "react";
import { useRun } from "../state/run";
import { useView } from "../state/view";
import { Timeline } from "../timeline/Timeline";
import { PanelFrame } from "./PanelFrame";
import { SplitView } from "./SplitView";
import { loadLayout, useLayout } from "./store";
import { panelsOf } from "./tree";
import "./layout.css";

/** The cockpit: the panels where the layout puts them, over the timeline. */
export function CockpitView() {
  const tree = useLayout((state) => state.tree);
  const open = useView((state) => state.full);
  const full = panelsOf(tree).find((id) => id === open);
  const ready = useRun((run) => run.experiment !== null);
  useEffect(() => {
    if (ready) void loadLayout();
  }, [ready]);
  return (
    <div className="cockpit">
      <h1 className="hidden-text">Cockpit</h1>
      {full ? <PanelFrame id={full} /> : <SplitView node={tree} />}
      <div className="cockpit-timeline" data-panel="timeline" tabIndex={-1}>
        <Timeline />
      </div>
    </div>
  );
}
