import { lazy, Suspense, useMemo, useRef } from "react";
import { useSpikes } from "../plots/spikeStore";
import { usePanelChoice } from "../state/panelChoices";
import { useRun } from "../state/run";
import type { Experiment } from "../state/types";
import { counted } from "../ui/counts";
import { Empty, Panel } from "../ui/Panel";
import { Segmented } from "../ui/Segmented";
import { GraphView } from "./GraphView";
import { layGraph } from "./graph";
import { linksOf } from "./links";
import { partsOf } from "./nodes";
import { useConnections } from "./useConnections";
import { useSize } from "./useSize";
import "./brain.css";

/** With three.js, which the first picture does not wait for. */
const CloudView = lazy(() => import("./cloud/CloudView"));

/** Populations and projections as a graph, or cells where they are in space; activity as brightness. */
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

const WAYS = [
  { value: "graph", label: "Graph" },
  { value: "space", label: "3D" },
] as const;

type Way = (typeof WAYS)[number]["value"];

function Brain({ experiment }: { experiment: Experiment }) {
  const { populations, projections } = experiment;
  const [chosen, choose] = usePanelChoice<Way>("graph");
  useSpikes(populations);
  const hasPlaces = populations.some(({ placed }) => placed);
  const way = hasPlaces ? chosen : "graph";
  const cells = populations.reduce((sum, population) => sum + population.size, 0);
  const sub = `${counted(cells, "cell")}, ${counted(projections.length, "projection")}`;
  const tools = (
    <>
      {way === "graph" && KEY}
      {hasPlaces && <Segmented label="View of the brain" choices={WAYS} value={way} onChange={choose} />}
    </>
  );
  return (
    <Panel title="Brain" sub={sub} tools={tools} className="brain">
      {way === "graph" ? (
        <BrainGraph experiment={experiment} />
      ) : (
        <Suspense fallback={null}>
          <CloudView populations={populations} devices={experiment.devices} />
        </Suspense>
      )}
    </Panel>
  );
}

function BrainGraph({
  experiment: { populations, groups, projections, devices },
}: {
  experiment: Experiment;
}) {
  const place = useRef<HTMLDivElement>(null);
  const size = useSize(place);
  const connections = useConnections(groups);
  const parts = useMemo(() => partsOf(populations, devices, groups), [populations, devices, groups]);
  const links = useMemo(() => linksOf(projections, parts, connections), [projections, parts, connections]);
  const graph = useMemo(() => size && layGraph(parts, links, size.width, size.height), [parts, links, size]);
  return (
    <div ref={place} className="brain-place">
      {graph && size && <GraphView graph={graph} {...size} />}
    </div>
  );
}
