import { useMemo, useRef } from "react";
import { useSpikes } from "../plots/spikeStore";
import { useRun } from "../state/run";
import type { Experiment } from "../state/types";
import { counted } from "../ui/counts";
import { Empty, Panel } from "../ui/Panel";
import { GraphView } from "./GraphView";
import { layGraph } from "./graph";
import { linksOf } from "./links";
import { partsOf } from "./nodes";
import { useConnections } from "./useConnections";
import { useSize } from "./useSize";
import "./brain.css";

/** Populations and projections as a graph; activity as brightness. */
export function BrainPanel() {
  const experiment = useRun((run) => run.experiment);
  if (experiment) return <Brain experiment={experiment} />;
  return (
    <Panel title="Brain">
      <Empty>Waiting for the populations.</Empty>
    </Panel>
  );
}

const KEY = (
  <span className="row wide" aria-hidden="true">
    <span className="key brain-excites">
      <i /> excites
    </span>
    <span className="key brain-inhibits">
      <i /> inhibits
    </span>
  </span>
);

function Brain({ experiment: { populations, groups, projections, devices } }: { experiment: Experiment }) {
  const place = useRef<HTMLDivElement>(null);
  const size = useSize(place);
  useSpikes(populations);
  const connections = useConnections(groups);
  const parts = useMemo(() => partsOf(populations, devices, groups), [populations, devices, groups]);
  const links = useMemo(() => linksOf(projections, parts, connections), [projections, parts, connections]);
  const graph = useMemo(() => size && layGraph(parts, links, size.width, size.height), [parts, links, size]);
  const cells = populations.reduce((sum, population) => sum + population.size, 0);
  const sub = `${counted(cells, "cell")}, ${counted(projections.length, "projection")}`;
  return (
    <Panel title="Brain" sub={sub} tools={KEY} className="brain">
      <div ref={place} className="brain-place">
        {graph && size && <GraphView graph={graph} {...size} />}
      </div>
    </Panel>
  );
}
