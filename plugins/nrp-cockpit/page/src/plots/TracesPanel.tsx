import { type DragEvent, useContext, useEffect, useMemo, useRef } from "react";
import { PanelContext } from "../state/panelContext";
import { useRun } from "../state/run";
import { carriesTrace, dropTrace, type Trace, useTraces } from "../state/traces";
import type { Device, TopicInfo } from "../state/types";
import { counted, thousands } from "../ui/counts";
import { Empty, Panel } from "../ui/Panel";
import { AddTrace } from "./AddTrace";
import { firstTraces, groupsOf, mainTraces } from "./groups";
import { TraceGroup } from "./TraceGroup";
import { keyOf, useTraceValues } from "./traceStore";
import { WindowTools } from "./WindowTools";
import "./plots.css";

const NONE: readonly Device[] = [];
const NO_TOPICS: readonly TopicInfo[] = [];
const over = (event: DragEvent) => carriesTrace(event.dataTransfer) && event.preventDefault();

/** Curves of devices and of fields of topics over the common window of time. */
export function TracesPanel() {
  const { id } = useContext(PanelContext);
  const all = useTraces((state) => state.traces);
  const traces = useMemo(() => all.filter(({ panel = "traces" }) => panel === id), [all, id]);
  const devices = useRun((run) => run.experiment?.devices ?? NONE);
  const topics = useRun((run) => run.experiment?.topics ?? NO_TOPICS);
  useFirstTraces(id);
  useTraceValues(traces);
  const hidden = useHidden(all);
  const groups = groupsOf(traces, devices, topics);
  const list = useNewInSight(groups.length);
  const tools = (
    <>
      <AddTrace panel={id} />
      <WindowTools plot="curves" />
    </>
  );
  const sub = hidden > 0 && (
    <span title={`${counted(hidden, "more curve")}: choose Add`}>{thousands(hidden)} more</span>
  );
  return (
    <Panel title="Devices and topics" sub={sub} tools={tools} className="plot traces scroll">
      {/* biome-ignore lint/a11y/noStaticElementInteractions: only a place to drop on; the menu Add does the same */}
      <div
        className="traces-drop"
        ref={list}
        onDragOver={over}
        onDrop={(event) => dropTrace(event.dataTransfer, id)}
      >
        {groups.length === 0 && <Empty>Drag a variable here, or choose Add.</Empty>}
        {groups.map((group, at) => (
          <TraceGroup key={group.title} group={group} last={at === groups.length - 1} />
        ))}
      </div>
    </Panel>
  );
}

/** How many of the curves that tell of the run are not shown: more than can be told apart are left out at first. */
function useHidden(shown: readonly Trace[]): number {
  const experiment = useRun((run) => run.experiment);
  return useMemo(() => {
    const keys = new Set(shown.map(keyOf));
    return experiment ? mainTraces(experiment).filter((trace) => !keys.has(keyOf(trace))).length : 0;
  }, [experiment, shown]);
}

/** Brings an axis into sight that a person adds. */
function useNewInSight(axes: number) {
  const list = useRef<HTMLDivElement>(null);
  const before = useRef(axes);
  useEffect(() => {
    const isAdded = axes > before.current && useTraces.getState().chosen;
    before.current = axes;
    if (isAdded) list.current?.lastElementChild?.scrollIntoView({ block: "nearest" });
  }, [axes]);
  return list;
}

let offered = "";

/** Shows the first curves of a run once, in the first panel, unless some are shown already. */
function useFirstTraces(panel: string): void {
  const experiment = useRun((run) => run.experiment);
  useEffect(() => {
    if (!experiment || experiment.file === offered || panel !== "traces") return;
    const traces = firstTraces(experiment);
    if (traces.length === 0) return; // the functions that have devices may come later
    offered = experiment.file;
    if (useTraces.getState().traces.length === 0) useTraces.setState({ traces });
  }, [experiment, panel]);
}
