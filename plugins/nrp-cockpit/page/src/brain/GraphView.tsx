import { useEffect, useMemo, useRef } from "react";
import { clock } from "../plots/clock";
import { useFrame } from "../plots/useFrame";
import { useSelection } from "../state/selection";
import { Rarely, READABLE_MS } from "../ui/rarely";
import type { Drawn, Graph } from "./graph";
import { EndMarks, ProjectionView } from "./LineView";
import { shine } from "./lights";
import { NodeView } from "./NodeView";

interface ViewProps {
  graph: Graph;
  width: number;
  height: number;
}

/** The graph as an SVG whose parts shine with their spikes. */
export function GraphView({ graph, width, height }: ViewProps) {
  const selected = useSelection((state) => state.selected);
  const svg = useRef<SVGSVGElement>(null);
  const projections = useMemo(() => [...new Set(graph.lines.map(({ link }) => link.projection))], [graph]);
  const redraw = useFrame(() => svg.current && shine(svg.current, graph, clock.now_s));
  useEffect(() => {
    const rarely = new Rarely(redraw, READABLE_MS);
    const leave = clock.onTick(() => rarely.ask());
    return () => {
      leave();
      rarely.stop();
    };
  }, [redraw]);
  const heaviest = useMemo(() => heaviestOf(graph.lines), [graph]);
  return (
    <svg ref={svg} className="brain-graph" viewBox={`0 0 ${width} ${height}`}>
      <title>The populations and projections of the brain</title>
      <EndMarks />
      {projections.map((projection) => (
        <ProjectionView
          key={projection.id}
          projection={projection}
          lines={graph.lines.filter(({ link }) => link.projection === projection)}
          heaviest={heaviest}
          selected={selected}
        />
      ))}
      {graph.nodes.map((node) => (
        <NodeView key={node.part.id} node={node} selected={selected} />
      ))}
    </svg>
  );
}

const heaviestOf = (lines: readonly Drawn[]) => Math.max(...lines.map(({ link }) => link.weight ?? 0), 1e-12);
