import { Fact, Facts, Section } from "./Facts";
import { barsOf } from "./samples";
import { useLook } from "./useLook";

interface Seen {
  counts: number[];
  borders: number[];
  summary: [number, number, number] | null;
}

const EVERY_MS = 1000;
const text = (weight: number) => Number(weight.toPrecision(3)).toString();

/** The weights of a projection as they are now, read while it is shown. */
export function Weights({ id }: { id: string }) {
  const seen = useLook<Seen>("weights", { projection: id }, EVERY_MS);
  if (seen === null) return null;
  if (typeof seen === "string")
    return (
      <Section title="Weights">
        <p className="mut f12">{seen}</p>
      </Section>
    );
  if (!seen.summary) return null;
  const [least, mean, most] = seen.summary;
  return (
    <Section title="Weights">
      <svg
        className="inspector-trace"
        viewBox="0 0 1 1"
        preserveAspectRatio="none"
        role="img"
        aria-label={`Histogram of the weights from ${text(least)} to ${text(most)}`}
      >
        {barsOf(seen.counts).map(({ x, width, height }) => (
          <rect key={x} x={x} y={1 - height} width={width * 0.9} height={height} />
        ))}
      </svg>
      <Facts>
        <Fact name="Smallest">{text(least)}</Fact>
        <Fact name="Mean">{text(mean)}</Fact>
        <Fact name="Largest">{text(most)}</Fact>
      </Facts>
    </Section>
  );
}
