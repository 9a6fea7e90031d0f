import { useEffect, useMemo, useState } from "react";
import { cellsIn, rangesRate, rateText } from "../brain/activity";
import { clock } from "../plots/clock";
import { heardOf, spikesOf, useSpikes } from "../plots/spikeStore";
import { useRun } from "../state/run";
import type { CellGroup, Experiment } from "../state/types";
import { READABLE_MS } from "../ui/rarely";
import { useRarely } from "../ui/useRarely";

/** The mean rate of the cells of a name in the last second of the run; nothing where the run has no such cells. */
export function LiveRate({ of }: { of: string }) {
  const experiment = useRun((run) => run.experiment);
  const cells = useMemo(() => experiment && cellsOf(of, experiment), [of, experiment]);
  const populations = useMemo(
    () => experiment?.populations.filter(({ label }) => cells?.[label]) ?? [],
    [cells, experiment],
  );
  const [text, setText] = useState(rateText(null));
  useSpikes(populations);
  const rarely = useRarely(READABLE_MS, () => setText(rateText(cells && meanRate(cells, clock.now_s))));
  useEffect(() => {
    rarely.ask();
    return clock.onTick(() => rarely.ask());
  }, [rarely]);
  return cells && <span className="num">{text}</span>;
}

type Cells = CellGroup["cells"];

/** The cells of a population or of a group; null: there are none of this name. */
function cellsOf(name: string, { populations, groups }: Experiment): Cells | null {
  const population = populations.find(({ label }) => label === name);
  if (population) return { [name]: [[0, population.size]] };
  return groups.find((group) => group.name === name)?.cells ?? null;
}

function meanRate(cells: Cells, now_s: number): number | null {
  let [sum_hz, size] = [0, 0];
  for (const [label, ranges] of Object.entries(cells)) {
    const rate_hz = rangesRate(spikesOf(label), heardOf(label), ranges, now_s);
    if (rate_hz === null) return null;
    sum_hz += rate_hz * cellsIn(ranges);
    size += cellsIn(ranges);
  }
  return size === 0 ? null : sum_hz / size;
}
