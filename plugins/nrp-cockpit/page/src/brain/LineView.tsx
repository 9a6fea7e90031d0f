import type { Selection } from "../state/selection";
import type { Projection } from "../state/types";
import type { Drawn } from "./graph";
import { selecting } from "./selecting";

/** The ends of lines: an arrow excites, an open circle inhibits. */
export function EndMarks() {
  return (
    <defs>
      <marker
        id="brain-excites"
        markerUnits="userSpaceOnUse"
        viewBox="0 0 8 8"
        refX="6"
        refY="4"
        markerWidth="8"
        markerHeight="8"
        orient="auto"
      >
        <path className="brain-arrow" d="M0 1 7 4 0 7z" />
      </marker>
      <marker
        id="brain-inhibits"
        markerUnits="userSpaceOnUse"
        viewBox="0 0 8 8"
        refX="4"
        refY="4"
        markerWidth="8"
        markerHeight="8"
        orient="auto"
      >
        <circle className="brain-ring" cx="4" cy="4" r="2.8" />
      </marker>
    </defs>
  );
}

interface LinesProps {
  projection: Projection;
  lines: readonly Drawn[];
  /** The largest weight in the graph, drawn widest. */
  heaviest: number;
  selected: Selection | null;
}

/** A projection: all its lines, as one button. */
export function ProjectionView({ projection, lines, heaviest, selected }: LinesProps) {
  const kind = projection.excites ? "excites" : "inhibits";
  const synapses = `${projection.size} ${projection.size === 1 ? "synapse" : "synapses"}`;
  const name = `Projection ${projection.label}: ${kind}, ${synapses}`;
  const width = (weight: number | null) => 1 + 1.2 * Math.sqrt((weight ?? heaviest) / heaviest);
  return (
    <g
      className={`brain-projection brain-${kind}`}
      {...selecting(name, { kind: "projection", id: projection.id }, selected)}
    >
      <title>{name}</title>
      {lines.map(({ link, path }) => (
        <path key={`${link.id} hit`} className="brain-hit" d={path} />
      ))}
      {lines.map(({ link, path }) => (
        <path
          key={link.id}
          className="brain-line"
          data-from={link.from.id}
          d={path}
          strokeWidth={width(link.weight)}
          markerEnd={`url(#brain-${kind})`}
        />
      ))}
    </g>
  );
}
