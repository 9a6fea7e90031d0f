import { cellsIn, sizeOf } from "../brain/grouping";
import { useRun } from "../state/run";
import { select } from "../state/selection";
import { counted } from "../ui/counts";
import { Empty } from "../ui/Panel";
import { Fact, Facts, Section, Title } from "./Facts";

/** A named group of cells: how many, and of which populations. */
export function GroupView({ name }: { name: string }) {
  const group = useRun((run) => run.experiment?.groups.find((one) => one.name === name));
  if (!group) return <Empty>The brain has no group '{name}' any more.</Empty>;
  const labels = Object.keys(group.cells);
  return (
    <>
      <Title name={name}>group · {counted(sizeOf(group), "cell")}</Title>
      <Section title="Cells">
        <Facts>
          {labels.map((label) => (
            <Fact key={label} name={counted(cellsIn(group.cells, label), "cell")}>
              <button
                type="button"
                className="inspector-link"
                onClick={() => select({ kind: "population", label })}
              >
                {label}
              </button>
            </Fact>
          ))}
        </Facts>
      </Section>
    </>
  );
}
