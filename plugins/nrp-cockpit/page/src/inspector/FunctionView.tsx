import { command } from "../state/commands";
import { openPlace } from "../state/place";
import { useBlocked, useRecorded, useRun } from "../state/run";
import { Button } from "../ui/Button";
import { thousands } from "../ui/counts";
import { Empty } from "../ui/Panel";
import { Switch } from "../ui/Switch";
import { Fact, Facts, Section, Title } from "./Facts";

/** One transfer function: whether it runs, what it costs, and why it failed. */
export function FunctionView({ name }: { name: string }) {
  const one = useRun((run) => run.functions?.functions.find((each) => each.name === name));
  const blocked = useBlocked();
  const recorded = useRecorded();
  if (!one) return <Empty>The run has no transfer function '{name}' any more.</Empty>;
  return (
    <>
      <Title name={name}>transfer function</Title>
      <Section title="Function">
        <Facts>
          <Fact name="Flow">{one.flow}</Fact>
          <Fact name="Place">{`${one.file.split("/").at(-1)}:${one.line}`}</Fact>
          {!recorded && <Fact name="Calls">{thousands(one.calls)}</Fact>}
          {!recorded && <Fact name="Mean time per call">{`${one.mean_ms.toFixed(3)} ms`}</Fact>}
        </Facts>
        <div className="row">
          <span className="f12 mut grow">Active</span>
          <Switch
            label={`${name} active`}
            on={one.active}
            disabled={blocked}
            onChange={(active) => void command("functions/activate", { name, active })}
          />
        </div>
        <Button small icon="functions" onClick={() => openPlace(one)}>
          Open the source
        </Button>
      </Section>
      {one.failure && (
        <Section title="Failure" note={`at ${one.failure.t_s.toFixed(2)} s`}>
          <p className="note note-bad">{one.failure.message}</p>
          <pre className="inspector-traceback mono scroll">{one.failure.traceback}</pre>
        </Section>
      )}
    </>
  );
}
