import { useRef } from "react";
import { CURVE_COLOURS } from "../plots/palette";
import { Section } from "./Facts";
import { extended, type Sample } from "./samples";
import { useLook } from "./useLook";

const EVERY_MS = 60;

/** The membrane potentials of some cells over the last seconds, read while they are shown. */
export function Membrane({ population, indices }: { population: string; indices: readonly number[] }) {
  const look = useLook<Sample>("membrane", { population, indices }, EVERY_MS);
  const samples = useRef<readonly Sample[]>([]);
  const title = indices.length > 1 ? "Membranes" : "Membrane";
  if (look === null || typeof look === "string")
    return (
      <Section title={title}>
        <p className="mut f12">{look ?? "–"}</p>
      </Section>
    );
  samples.current = extended(samples.current, look);
  return (
    <Section title={title}>
      {indices.length === 1 && <p className="num">{look.v_mv[0]?.toFixed(1)} mV</p>}
      <Trace samples={samples.current} />
      {indices.length > 1 && (
        <ul className="inspector-keys">
          {indices.map((index, at) => (
            <li key={index} className="key">
              <i style={colourOf(at)} />
              {index} <b className="num">{look.v_mv[at]?.toFixed(1)} mV</b>
            </li>
          ))}
        </ul>
      )}
    </Section>
  );
}

const colourOf = (at: number) =>
  ({ "--c": `var(${CURVE_COLOURS[at % CURVE_COLOURS.length]})` }) as React.CSSProperties;

const WIDTH = 220;
const HEIGHT = 56;

function Trace({ samples }: { samples: readonly Sample[] }) {
  const values = samples.flatMap(({ v_mv }) => v_mv);
  const [least, most] = [Math.min(...values), Math.max(...values)];
  const [from_s, to_s] = [samples[0]?.t_s ?? 0, samples.at(-1)?.t_s ?? 0];
  const x = (t_s: number) => ((t_s - from_s) / Math.max(to_s - from_s, 1e-9)) * WIDTH;
  const y = (v_mv: number) => HEIGHT - 2 - ((v_mv - least) / Math.max(most - least, 1e-3)) * (HEIGHT - 4);
  const points = (cell: number) =>
    samples.map(({ t_s, v_mv }) => `${x(t_s)},${y(v_mv[cell] ?? 0)}`).join(" ");
  return (
    <svg
      className="inspector-trace"
      viewBox={`0 0 ${WIDTH} ${HEIGHT}`}
      preserveAspectRatio="none"
      role="img"
      aria-label={`Membrane potential from ${least.toFixed(1)} to ${most.toFixed(1)} mV`}
    >
      {samples[0]?.v_mv.map((_, cell) => (
        // biome-ignore lint/suspicious/noArrayIndexKey: the cells are always the same ones
        <polyline key={cell} style={{ ...colourOf(cell), stroke: "var(--c)" }} points={points(cell)} />
      ))}
    </svg>
  );
}
