import { useRef } from "react";
import { Section } from "./Facts";
import { extended, type Sample } from "./samples";
import { useLook } from "./useLook";

const EVERY_MS = 60;

/** The membrane potential of a cell over the last seconds, read while it is shown. */
export function Membrane({ population, index }: { population: string; index: number }) {
  const look = useLook<Sample>("membrane", { population, index }, EVERY_MS);
  const samples = useRef<readonly Sample[]>([]);
  if (look === null) return null;
  if (typeof look === "string")
    return (
      <Section title="Membrane">
        <p className="mut f12">{look}</p>
      </Section>
    );
  samples.current = extended(samples.current, look);
  return (
    <Section title="Membrane">
      <p className="num">{look.v_mv.toFixed(1)} mV</p>
      <Trace samples={samples.current} />
    </Section>
  );
}

const WIDTH = 220;
const HEIGHT = 56;

function Trace({ samples }: { samples: readonly Sample[] }) {
  const values = samples.map(({ v_mv }) => v_mv);
  const [least, most] = [Math.min(...values), Math.max(...values)];
  const [from_s, to_s] = [samples[0]?.t_s ?? 0, samples.at(-1)?.t_s ?? 0];
  const x = (t_s: number) => ((t_s - from_s) / Math.max(to_s - from_s, 1e-9)) * WIDTH;
  const y = (v_mv: number) => HEIGHT - 2 - ((v_mv - least) / Math.max(most - least, 1e-3)) * (HEIGHT - 4);
  return (
    <svg
      className="inspector-trace"
      viewBox={`0 0 ${WIDTH} ${HEIGHT}`}
      preserveAspectRatio="none"
      role="img"
      aria-label={`Membrane potential from ${least.toFixed(1)} to ${most.toFixed(1)} mV`}
    >
      <polyline points={samples.map(({ t_s, v_mv }) => `${x(t_s)},${y(v_mv)}`).join(" ")} />
    </svg>
  );
}
