import type { Selection } from "../state/selection";
import { thousands } from "../ui/counts";
import type { Placed } from "./graph";
import { groupOf, type Part } from "./nodes";
import { selecting } from "./selecting";

function selectionOf(part: Part): Selection {
  const { population, index } = part;
  const { label } = population;
  if (index !== null) return { kind: "neuron", population: label, index };
  const group = groupOf(part);
  return group === null ? { kind: "population", label } : { kind: "group", name: group };
}

function wordsOf(part: Part): string {
  const { population, index, name, size } = part;
  if (index !== null)
    return `Neuron ${population.first + index} of ${population.label}${name && `: ${name}`}`;
  const group = groupOf(part);
  const what = group === null ? `Population ${name}` : `Group ${group} of ${population.label}`;
  return `${what}: ${size} cells of ${population.cell}`;
}

/** A part of the brain as a button; `lights.ts` sets its brightness and its rate. */
export function NodeView({ node, selected }: { node: Placed; selected: Selection | null }) {
  const { part } = node;
  const words = wordsOf(part);
  return (
    <g
      className={`brain-node brain-${part.role}`}
      data-part={part.id}
      {...selecting(words, selectionOf(part), selected)}
    >
      <title>{words}</title>
      {part.index === null ? (
        <Box node={node} />
      ) : (
        <Neuron node={node} number={part.population.first + part.index} />
      )}
    </g>
  );
}

/** As much of a text as has room, with both ends: names often differ in the last letters. */
function shortened(text: string, letters: number): string {
  if (text.length <= letters) return text;
  const kept = Math.max(1, letters - 1);
  const front = Math.ceil(kept / 2);
  return `${text.slice(0, front)}…${text.slice(text.length - (kept - front))}`;
}

/** The mean width of a digit in a circle. */
const DIGIT_PX = 7;

function Neuron({ node, number }: { node: Placed; number: number }) {
  const { part, x, y, rx } = node;
  const inside = String(number).length * DIGIT_PX < 2 * rx;
  const crowded = node.side === "above" && node.tight;
  return (
    <>
      <circle className="brain-shape" cx={x} cy={y} r={rx} />
      <circle className="brain-light" cx={x} cy={y} r={rx} />
      {inside && (
        <text className="brain-number" x={x} y={y} dy="0.35em" textAnchor="middle">
          {number}
        </text>
      )}
      {!crowded && <Words node={node} name={inside ? part.name : part.name || String(number)} />}
    </>
  );
}

/** The name of a neuron and its rate: around those in the middle, beside the others. */
function Words({ node: { x, y, rx, side, letters, tight }, name }: { node: Placed; name: string }) {
  const anchor = ({ left: "end", right: "start", above: "middle" } as const)[side];
  const at = { left: x - rx - 8, right: x + rx + 8, above: x }[side];
  const two = side === "above" || (name !== "" && !tight);
  const [nameY, rateY] =
    side === "above" ? [y - rx - 6, y + rx + 13] : two ? [y - 2, y + 11] : [y + 4, y + 4];
  return (
    <text className="brain-name" textAnchor={anchor}>
      <tspan x={at} y={nameY}>
        {shortened(name, letters)}
      </tspan>
      {two ? (
        <tspan className="brain-rate" x={at} y={rateY} />
      ) : (
        <tspan className="brain-rate" dx={name && 4} />
      )}
    </text>
  );
}

/** A box this high has its name above its rate; in a lower one they stand beside each other. */
const TWO_LINES_RY = 17.5;
/** The room of a rate beside a name, and half the width of a box that has it and its size beside each other. */
const RATE_LETTERS = 6;
const BOTH_RX = 42;

function Box({ node: { part, x, y, rx, ry, letters } }: { node: Placed }) {
  const [left, top] = [x - rx, y - ry];
  const low = ry < TWO_LINES_RY;
  const hasRate = !low || part.name.length + RATE_LETTERS <= letters;
  const [rateX, rateY] = low ? [x + rx - 6, top + 12] : [left + 8, top + 27];
  return (
    <>
      <rect className="brain-shape" x={left} y={top} width={2 * rx} height={2 * ry} rx="6" />
      <text className="brain-name" x={left + (low ? 6 : 8)} y={top + (low ? 12 : 14)}>
        {shortened(part.name, letters)}
      </text>
      {hasRate && <text className="brain-rate" x={rateX} y={rateY} textAnchor={low ? "end" : "start"} />}
      {!low && rx >= BOTH_RX && (
        <text className="brain-rate-size" x={x + rx - 8} y={top + 27} textAnchor="end">
          {thousands(part.size)}
        </text>
      )}
      <rect className="brain-bar" x={left + 8} y={y + ry - 6} width={2 * rx - 16} height="3" rx="1.5" />
      <rect className="brain-bar-on" x={left + 8} y={y + ry - 6} width={2 * rx - 16} height="3" rx="1.5" />
    </>
  );
}
