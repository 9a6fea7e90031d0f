import { thousands } from "../ui/counts";
import type { Row } from "./PlotTable";
import type { Spans } from "./spans";
import { valueText } from "./timeAxis";
import type { TimeRing } from "./timeRing";

export const CURVE_COLUMNS = ["Curve", "Now", "Lowest", "Highest"];
export const SPIKE_COLUMNS = ["Population", "Cells", "Spikes", "Mean rate"];

const UNKNOWN = "–";

/** A curve in numbers: its value at the end of a window, its lowest and its highest in it. */
export function curveRow(label: string, series: TimeRing, from_s: number, to_s: number): Row {
  const last = series.indexAt(to_s + 1e-9) - 1;
  if (last < 0) return [label, UNKNOWN, UNKNOWN, UNKNOWN];
  const now = series.valueAt(last);
  let [lowest, highest] = [now, now];
  series.visit(from_s, to_s, (_, value) => {
    lowest = Math.min(lowest, value);
    highest = Math.max(highest, value);
  });
  return [label, now, lowest, highest].map((each) => (typeof each === "string" ? each : valueText(each)));
}

/** A population in numbers: its spikes in a window, and its mean rate there; unknown where it was not heard. */
export function spikeRow(
  { label, size }: { label: string; size: number },
  series: TimeRing,
  heard: Spans,
  from_s: number,
  to_s: number,
): Row {
  const cells = thousands(size);
  if (!heard.has(to_s) || heard.gaps(from_s, to_s).length > 0 || to_s <= from_s)
    return [label, cells, UNKNOWN, UNKNOWN];
  const spikes = series.indexAt(to_s) - series.indexAt(from_s);
  return [label, cells, thousands(spikes), `${valueText(spikes / size / (to_s - from_s))} Hz`];
}
