import { useRun } from "../state/run";
import { addTrace } from "../state/traces";
import { Chooser } from "../ui/Chooser";
import { wire } from "../wire";
import { offeredTraces } from "./offered";
import { keyOf } from "./traceStore";

/** A button that opens the list of all numbers of all topics, to be searched by words. */
export function AddTrace({ panel }: { panel: string }) {
  const experiment = useRun((run) => run.experiment);
  return (
    <Chooser
      icon="plus"
      kind="ghost"
      small
      title="Add a curve"
      search="Search the topics"
      choices={() => offeredTraces(wire.offered(), experiment?.devices ?? [], experiment?.topics ?? [])}
      textOf={keyOf}
      show={(trace) => (
        <>
          <span className="cut cut-front mut">
            <bdi>{trace.topic}</bdi>
          </span>
          <b className="mono">{trace.path}</b>
        </>
      )}
      none="No number matches."
      onChoose={(trace) => addTrace({ ...trace, panel })}
    >
      Add
    </Chooser>
  );
}
