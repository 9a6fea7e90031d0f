import { type CSSProperties, useId } from "react";
import { CURVE_COLOURS } from "../plots/palette";
import { command } from "../state/commands";
import { notify } from "../state/notices";
import { useBlocked, useMissing, useRun } from "../state/run";
import { addTrace } from "../state/traces";
import type { TopicInfo } from "../state/types";
import { Button, IconButton } from "../ui/Button";
import { Chooser } from "../ui/Chooser";
import { wire } from "../wire";
import { Section } from "./Facts";
import { outlinesOf, pin, type Seen, unpin, usePins } from "./pins";
import { useLook } from "./useLook";

const EVERY_MS = 1000;
const FACTORS = [
  ["\u00d7 0", 0],
  ["\u00d7 \u00bd", 0.5],
  ["\u00d7 2", 2],
] as const;
const NO_PINS: readonly Seen[] = [];
const NO_TOPICS: readonly TopicInfo[] = [];
const summaryTopic = (id: string) => `/brain/projections/${id}/weights`;
const text = (weight: number) => Number(weight.toPrecision(3)).toString();
const colourOf = (at: number) => ({ "--c": `var(${CURVE_COLOURS[at]})` }) as CSSProperties;

/** The weights of a projection as they are now, read while it is shown, beside those of pinned moments. */
export function Weights({ id }: { id: string }) {
  const seen = useLook<Seen>("weights", { projection: id }, EVERY_MS);
  const pins = usePins((state) => state.pins[id] ?? NO_PINS);
  const unit = useRun(
    ({ experiment }) => experiment?.topics.find(({ name }) => name === summaryTopic(id))?.unit,
  );
  if (seen === null || typeof seen === "string")
    return (
      <Section title="Weights">
        <p className="mut f12">{seen ?? "–"}</p>
      </Section>
    );
  if (!seen.summary) return null;
  const all = [seen, ...pins];
  return (
    <Section title="Weights" note={unit}>
      <Histograms all={all} />
      <table className="inspector-weights">
        <thead>
          <tr>
            <th scope="col">At</th>
            <th scope="col">Smallest</th>
            <th scope="col">Mean</th>
            <th scope="col">Largest</th>
            <th />
          </tr>
        </thead>
        <tbody>
          {all.map((one, at) => (
            <Moment key={at === 0 ? "now" : one.t_s} id={id} seen={one} number={at} />
          ))}
        </tbody>
      </table>
      <div className="row wrap">
        <Button small onClick={() => void pinNow(id)} tip="Keep the weights of now, to compare them later">
          Pin
        </Button>
        <PlotWeights id={id} />
      </div>
      <ChangeWeights id={id} unit={unit ?? ""} />
    </Section>
  );
}

/** What is shown may be a second old. */
async function pinNow(id: string): Promise<void> {
  try {
    pin(id, await wire.call<Seen>("/cockpit/weights", { projection: id }));
  } catch (error) {
    notify((error as Error).message, "bad");
  }
}

/** Changes the weights of the run, and pins the previous ones for comparison. */
function ChangeWeights({ id, unit }: { id: string; unit: string }) {
  const barred = [useBlocked(), useMissing("weights")].find((reason) => reason !== undefined);
  const field = useId();
  const change = async (how: "set" | "scale", value: object) => {
    await pinNow(id);
    await command(`weights/${how}`, { projection: id, ...value });
  };
  return (
    <form
      className="inspector-change"
      onSubmit={(event) => {
        event.preventDefault();
        const given = String(new FormData(event.currentTarget).get("weight"));
        if (given !== "" && Number.isFinite(Number(given))) void change("set", { weight: Number(given) });
      }}
    >
      {FACTORS.map(([name, factor]) => (
        <Button
          key={name}
          small
          disabled={barred}
          tip={`Multiply all weights by ${factor} from now on`}
          onClick={() => void change("scale", { factor })}
        >
          {name}
        </Button>
      ))}
      <label htmlFor={field} className="hidden-text">
        Weight of all synapses
      </label>
      <input
        id={field}
        name="weight"
        className="input num inspector-weight"
        inputMode="decimal"
        placeholder={unit || "weight"}
        disabled={barred !== undefined}
      />
      <Button small type="submit" disabled={barred} tip="Give all synapses this weight from now on">
        Set
      </Button>
    </form>
  );
}

function Histograms({ all }: { all: readonly Seen[] }) {
  const borders = all.flatMap((one) => one.borders);
  const [least, most] = [Math.min(...borders), Math.max(...borders)];
  return (
    <>
      <svg
        className="inspector-trace inspector-outlines"
        viewBox="0 0 1 1"
        preserveAspectRatio="none"
        role="img"
        aria-label={`Histogram of the weights from ${text(least)} to ${text(most)}`}
      >
        {outlinesOf(all).map((points, at) => (
          <polyline
            key={at === 0 ? "now" : all[at]?.t_s}
            style={colourOf(at)}
            points={points.map(([x, y]) => `${x},${1 - y}`).join(" ")}
          />
        ))}
      </svg>
      <p className="inspector-ends dim f11 num" aria-hidden="true">
        <span>{text(least)}</span>
        <span>{text(most)}</span>
      </p>
    </>
  );
}

function Moment({ id, seen: { t_s, summary }, number }: { id: string; seen: Seen; number: number }) {
  return (
    <tr>
      <th scope="row">
        <span className="key">
          <i style={colourOf(number)} />
          {number === 0 ? "now" : `${Number(t_s.toFixed(3))} s`}
        </span>
      </th>
      {(summary ?? []).map((weight, at) => (
        // biome-ignore lint/suspicious/noArrayIndexKey: smallest, mean and largest
        <td key={at} className="num">
          {text(weight)}
        </td>
      ))}
      <td>
        {number > 0 && (
          <IconButton icon="close" label="Unpin" kind="ghost" small onClick={() => unpin(id, t_s)} />
        )}
      </td>
    </tr>
  );
}

/** The numbers of the summary that are plotted at first. */
const FIRST = ["mean", "5 %", "95 %"];

/** Buttons that add the summary of the weights, or single ones, to the curves. */
function PlotWeights({ id }: { id: string }) {
  const topics = useRun((run) => run.experiment?.topics ?? NO_TOPICS);
  const named = (topic: string) => topics.find(({ name }) => name === topic);
  const [summary, synapses] = [named(summaryTopic(id)), named(`/brain/projections/${id}/synapses`)];
  if (!summary) return null;
  const plot = ({ name, elements }: TopicInfo, element: string) =>
    addTrace({ topic: name, path: `data[${elements.indexOf(element)}]` });
  return (
    <>
      <Button
        small
        icon="plot"
        tip="Plot mean and quantiles over time"
        onClick={() => FIRST.map((one) => plot(summary, one))}
      >
        Over time
      </Button>
      {synapses && (
        <Chooser
          icon="plus"
          kind="ghost"
          small
          title="Plot the weight of a synapse"
          search="Search the synapses"
          choices={() => synapses.elements}
          textOf={(ends) => ends}
          none="No synapse between these cells is sampled."
          onChoose={(ends) => plot(synapses, ends)}
        >
          Synapse
        </Chooser>
      )}
    </>
  );
}
