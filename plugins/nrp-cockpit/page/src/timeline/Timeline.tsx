import { useState } from "react";
import { useComparison } from "../difference/comparison";
import { useRun } from "../state/run";
import type { TimelineData } from "../state/types";
import { CriteriaLane } from "./CriteriaLane";
import { DifferenceLane } from "./DifferenceLane";
import { ErrorBanner } from "./ErrorBanner";
import { EventLane } from "./EventLane";
import { Now } from "./Now";
import { SnapshotLane } from "./SnapshotLane";
import { type Span, showing, wholeSpan, zoomed } from "./scale";
import { TimelineHead } from "./TimelineHead";
import { Track } from "./Track";
import "./timeline.css";

/** Events, criteria, failures and snapshots over simulated time, and the time itself as a slider. */
export function Timeline() {
  const data = useRun((run) => run.timeline);
  return (
    <>
      <ErrorBanner />
      <section className="panel" aria-label="Timeline">
        {data ? <Lines data={data} /> : <p className="timeline-empty mut">Waiting for the timeline.</p>}
      </section>
    </>
  );
}

function Lines({ data }: { data: TimelineData }) {
  const [zoom, setZoom] = useState<Span | null>(null);
  const whole = useWhole(data);
  const comparison = useComparison((state) => state.comparison);
  const shown = useShown(zoom, whole);
  const zoomBy = (factor: number, at_s = useRun.getState().status?.t_s ?? 0) => {
    const next = zoomed(shown, whole, factor, at_s);
    setZoom(next.to_s - next.from_s < whole.to_s - whole.from_s ? next : null);
  };
  return (
    <div className="timeline">
      <TimelineHead onZoom={zoomBy} zoomedIn={zoom !== null} compared={comparison !== null} />
      <Track span={shown} end_s={whole.to_s} onZoom={zoomBy}>
        <EventLane data={data} span={shown} />
        <CriteriaLane criteria={data.criteria} span={shown} />
        <SnapshotLane data={data} span={shown} />
        {comparison && <DifferenceLane comparison={comparison} span={shown} />}
        <Now span={shown} />
      </Track>
    </div>
  );
}

/** The whole span; rendered again only when it grows, not with every message of the status. */
function useWhole(data: TimelineData): Span {
  const to_s = useRun((run) => wholeSpan(data, run.status?.t_s ?? 0).to_s);
  return { from_s: 0, to_s };
}

/** The visible span: the zoom, moved on when the run leaves it. */
function useShown(zoom: Span | null, whole: Span): Span {
  const from_s = useRun((run) => (zoom ? showing(zoom, whole, run.status?.t_s ?? 0).from_s : 0));
  return zoom ? { from_s, to_s: from_s + zoom.to_s - zoom.from_s } : whole;
}
