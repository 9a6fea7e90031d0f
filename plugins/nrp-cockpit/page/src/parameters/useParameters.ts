import { useCallback, useEffect, useState } from "react";
import { command } from "../state/commands";
import { useRun, useTimesBack } from "../state/run";
import type { Selection } from "../state/selection";
import type { Parameters } from "./numbers";

/** The numbers of the run or of the selected cell, asked for again whenever they may have changed; and what asks. */
export function useParameters(selected: Selection | null): [Parameters | null, () => Promise<void>] {
  const [parameters, setParameters] = useState<Parameters | null>(null);
  const experiment = useRun((run) => run.experiment);
  const functions = useRun((run) => run.functions);
  const back = useTimesBack();
  const population = selected?.kind === "neuron" ? selected.population : undefined;
  const index = selected?.kind === "neuron" ? selected.index : undefined;
  const read = useCallback(async () => {
    const found = await command<Parameters>("parameters", { population, index });
    if (found) setParameters(found);
  }, [population, index]);
  // biome-ignore lint/correctness/useExhaustiveDependencies: a change of these may change the numbers
  useEffect(() => {
    if (experiment) void read();
  }, [read, experiment, functions, back]);
  return [parameters, read];
}
