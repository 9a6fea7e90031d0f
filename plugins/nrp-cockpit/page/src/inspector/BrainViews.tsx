import { useRun } from "../state/run";
import { type Selection, select } from "../state/selection";
import type { Experiment, Population, Projection } from "../state/types";
import { counted } from "../ui/counts";
import { Empty } from "../ui/Panel";
import { Numbers } from "./BodyTopics";
import { devicesOf, synapsesOf, weightsOf } from "./brainFacts";
import { Fact, Facts, Section, Title } from "./Facts";
import { Membrane } from "./Membrane";
import { Weights } from "./Weights";

function Link({ to, children }: { to: Selection; children: string }) {
  return (
    <button type="button" className="inspector-link" onClick={() => select(to)}>
      {children}
    </button>
  );
}

const weightText = (weight: number) => Number(weight.toPrecision(3)).toString();

/** One neuron: its place in the brain, its synapses, the devices that drive or read it. */
export function NeuronView({ population: label, index }: { population: string; index: number }) {
  const experiment = useRun((run) => run.experiment);
  const population = experiment?.populations.find((one) => one.label === label);
  if (!experiment || !population) return <Empty>The brain has no population '{label}' any more.</Empty>;
  const neuron = population.first + index;
  const devices = devicesOf(experiment.devices, neuron);
  const { from, to } = synapsesOf(experiment, label, index);
  const position = population.positions?.[index];
  return (
    <>
      <Title name={`${label} ${index}`}>neuron</Title>
      <Section title="Neuron">
        <Facts>
          <Fact name="Population">
            <Link to={{ kind: "population", label }}>{label}</Link>
          </Fact>
          <Fact name="Cell">{population.cell}</Fact>
          <Fact name="Index in the brain">{neuron}</Fact>
          <Fact name="Position">
            {position ? position.map((value) => Number(value.toPrecision(3))).join(", ") : null}
          </Fact>
          <Fact name="Outgoing synapses">{from}</Fact>
          <Fact name="Incoming synapses">{to}</Fact>
        </Facts>
      </Section>
      {experiment.source === "live" && (
        <Membrane key={`${label} ${index}`} population={label} indices={[index]} />
      )}
      {devices.length > 0 && (
        <Section title="Devices">
          {devices.map((device) => (
            <DeviceRow key={device.topic} {...device} />
          ))}
        </Section>
      )}
    </>
  );
}

function DeviceRow({ name, kind, unit, topic }: Experiment["devices"][number]) {
  return (
    <div className="inspector-topic">
      <p className="mono cut" title={topic}>
        {name}
      </p>
      <p className="dim f11">
        {[kind === "sink" ? "reads it" : "drives it", unit].filter(Boolean).join(" · ")}
      </p>
      <Numbers topic={topic} />
    </div>
  );
}

const ROLES: Record<Population["role"], string> = {
  sensor: "driven from outside",
  actor: "read by the robot",
  circuit: "inside the brain",
};

/** One population: its cells, its projections, its devices. */
export function PopulationView({ label }: { label: string }) {
  const experiment = useRun((run) => run.experiment);
  const population = experiment?.populations.find((one) => one.label === label);
  if (!experiment || !population) return <Empty>The brain has no population '{label}' any more.</Empty>;
  const devices = experiment.devices.filter((device) => device.population === label);
  return (
    <>
      <Title name={label}>population · {counted(population.size, "cell")}</Title>
      <Section title="Cells">
        <Facts>
          <Fact name="Cell">{population.cell}</Fact>
          <Fact name="Role">{ROLES[population.role]}</Fact>
          <Fact name="First index in the brain">{population.first}</Fact>
        </Facts>
      </Section>
      <Projections title="Outgoing projections" end="pre" label={label} all={experiment.projections} />
      <Projections title="Incoming projections" end="post" label={label} all={experiment.projections} />
      {devices.length > 0 && (
        <Section title="Devices">
          {devices.map((device) => (
            <DeviceRow key={device.topic} {...device} />
          ))}
        </Section>
      )}
    </>
  );
}

interface ProjectionsProps {
  title: string;
  end: "pre" | "post";
  label: string;
  all: readonly Projection[];
}

function Projections({ title, end, label, all }: ProjectionsProps) {
  const here = all.filter((projection) => projection[end] === label);
  if (here.length === 0) return null;
  return (
    <Section title={title}>
      <ul>
        {here.map(({ id, label: name }) => (
          <li key={id}>
            <Link to={{ kind: "projection", id }}>{name}</Link>
          </li>
        ))}
      </ul>
    </Section>
  );
}

/** One projection: its ends, its synapses, their weights. */
export function ProjectionView({ id }: { id: string }) {
  const projection = useRun((run) => run.experiment?.projections.find((one) => one.id === id));
  const live = useRun((run) => run.experiment?.source === "live");
  if (!projection) return <Empty>The brain has no projection '{id}' any more.</Empty>;
  const { label, pre, post, receptor, synapse, size, excites } = projection;
  const weights = weightsOf(projection);
  return (
    <>
      <Title name={label}>
        projection · {excites ? "excites" : "inhibits"} · {counted(size, "synapse")}
      </Title>
      <Section title="Projection">
        <Facts>
          <Fact name="From">
            <Link to={{ kind: "population", label: pre }}>{pre}</Link>
          </Fact>
          <Fact name="To">
            <Link to={{ kind: "population", label: post }}>{post}</Link>
          </Fact>
          <Fact name="Receptor">{receptor}</Fact>
          <Fact name="Synapse">{synapse}</Fact>
        </Facts>
      </Section>
      {live ? (
        <Weights key={id} id={id} />
      ) : (
        weights && (
          <Section title="Weights">
            <Facts>
              <Fact name="Smallest">{weightText(weights.least)}</Fact>
              <Fact name="Mean">{weightText(weights.mean)}</Fact>
              <Fact name="Largest">{weightText(weights.most)}</Fact>
            </Facts>
          </Section>
        )
      )}
    </>
  );
}
