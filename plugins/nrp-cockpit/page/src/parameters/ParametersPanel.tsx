import { command } from "../state/commands";
import { notify } from "../state/notices";
import { baseName } from "../state/paths";
import { useBlocked } from "../state/run";
import { useSelection } from "../state/selection";
import type { Finding } from "../state/types";
import { Empty, Panel } from "../ui/Panel";
import type { ChangeableNumber } from "./numbers";
import { recheckSoon } from "./recheck";
import { Slider } from "./Slider";
import { useParameters } from "./useParameters";
import "./parameters.css";

/** The numbers of functions and cells that can be changed while the run goes on: all, or those of the selected cell. */
export function ParametersPanel() {
  const selected = useSelection((state) => state.selected);
  const [parameters, read] = useParameters(selected);
  if (!parameters)
    return (
      <Panel title="Parameters">
        <Empty>Waiting for the parameters.</Empty>
      </Panel>
    );
  const { functions, populations } = parameters;
  const isNone = functions.length === 0 && populations.every(({ numbers }) => numbers.length === 0);
  return (
    <Panel title="Parameters" className="scroll parameters">
      {isNone && <Empty>Neither the brain nor the functions have numbers to change.</Empty>}
      {functions.map(({ file, numbers }) => (
        <Numbers
          key={file}
          title={baseName(file)}
          numbers={numbers}
          onChange={async (name, value) => {
            told(await command<Applied>("parameters/function", { file, name, value }));
            recheckSoon();
            await read();
          }}
        />
      ))}
      {populations.map(({ population, index, numbers }) => (
        <Numbers
          key={population}
          title={index === null ? population : `${population}[${index}]`}
          numbers={numbers}
          onChange={async (name, value) => {
            await command("parameters/cells", { population, index, name, value });
            await read();
          }}
        />
      ))}
    </Panel>
  );
}

interface Applied {
  applied: boolean;
  findings: Finding[];
}

/** Says why the functions are still the old ones, if they are. */
function told(found: Applied | null): void {
  const [first] = found?.findings ?? [];
  if (found && !found.applied) notify(first?.summary ?? "The functions cannot be changed.", "bad");
}

interface NumbersProps {
  title: string;
  numbers: readonly ChangeableNumber[];
  onChange: (name: string, value: number) => Promise<void>;
}

function Numbers({ title, numbers, onChange }: NumbersProps) {
  const blocked = useBlocked();
  return (
    <section className="panel-section" aria-label={`Parameters of ${title}`}>
      <h3>{title}</h3>
      <ul>
        {numbers.map((number) => (
          <Slider
            key={number.name}
            number={number}
            of={title}
            disabled={blocked !== undefined}
            onChange={(value) => onChange(number.name, value)}
          />
        ))}
      </ul>
    </section>
  );
}
