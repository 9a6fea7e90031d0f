import type { Between } from "../brain/connections";
import { useConnections } from "../brain/useConnections";
import { cellsIn, sizeOf } from "../state/grouping";
import { useRun } from "../state/run";
import { type Selection, select } from "../state/selection";
import type { CellGroup, Experiment } from "../state/types";
import { counted, thousands } from "../ui/counts";
import { Empty } from "../ui/Panel";
import { Fact, Facts, Section, Title } from "./Facts";
import { GroupRate } from "./GroupRate";
import { Membrane } from "./Membrane";

/** Of a group so many membranes are shown, of cells that are equally far apart. */
const MEMBRANES = 4;

/** A named group of cells: its rate, some membranes, and the synapses from and to it. */
export function GroupView({ name }: { name: string }) {
  const experiment = useRun((run) => run.experiment);
  const group = experiment?.groups.find((one) => one.name === name);
  if (!experiment || !group) return <Empty>The brain has no group '{name}' any more.</Empty>;
  return <Group key={name} group={group} experiment={experiment} />;
}

function Group({ group, experiment }: { group: CellGroup; experiment: Experiment }) {
  const connections = useConnections(experiment.groups);
  const labels = Object.keys(group.cells);
  const populations = experiment.populations.filter(({ label }) => labels.includes(label));
  const [first] = populations;
  return (
    <>
      <Title name={group.name}>group · {counted(sizeOf(group), "cell")}</Title>
      <Section title="Cells">
        <Facts>
          {labels.map((label) => (
            <Fact key={label} name={counted(cellsIn(group.cells, label), "cell")}>
              <Choose to={{ kind: "population", label }}>{label}</Choose>
            </Fact>
          ))}
        </Facts>
      </Section>
      <GroupRate group={group} populations={populations} cells={sizeOf(group)} />
      {experiment.source === "live" && first && !first.cell.startsWith("SpikeSource") && (
        <Membrane population={first.label} indices={someOf(group.cells[first.label] ?? [])} />
      )}
      {connections && <Synapses title="Synapses to it" all={connections.of(group.name, "to")} />}
      {connections && <Synapses title="Synapses from it" all={connections.of(group.name, "from")} />}
    </>
  );
}

/** Some cells of ranges, equally far apart. */
function someOf(ranges: readonly (readonly [number, number])[]): number[] {
  const size = ranges.reduce((sum, [from, to]) => sum + to - from, 0);
  const count = Math.min(size, MEMBRANES);
  const cellAt = (place: number) => {
    let left = place;
    for (const [from, to] of ranges) {
      if (left < to - from) return from + left;
      left -= to - from;
    }
    return 0;
  };
  return Array.from({ length: count }, (_, at) => cellAt(Math.floor((at * size) / count)));
}

function Choose({ to, children }: { to: Selection; children: string }) {
  return (
    <button type="button" className="inspector-link" onClick={() => select(to)}>
      {children}
    </button>
  );
}

const MOST = 12;

/** The groups at the other end, with the number of synapses and their mean weight at the beginning. */
function Synapses({ title, all }: { title: string; all: readonly Between[] }) {
  if (all.length === 0) return null;
  const cells = ({ group, population }: Between): Selection =>
    group === null ? { kind: "population", label: population } : { kind: "group", name: group };
  return (
    <Section title={title} note="count, weight">
      <table className="inspector-weights">
        <tbody>
          {all.slice(0, MOST).map((one) => (
            <tr key={`${one.projection} ${one.population} ${one.group}`}>
              <th scope="row">
                <Choose to={cells(one)}>{one.name}</Choose>
              </th>
              <td className="num">{thousands(one.synapses)}</td>
              <td className="num">{Number(one.weight.toPrecision(3))}</td>
            </tr>
          ))}
        </tbody>
      </table>
      {all.length > MOST && <p className="dim f11">{all.length - MOST} more</p>}
    </Section>
  );
}
