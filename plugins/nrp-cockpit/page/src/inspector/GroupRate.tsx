import { useEffect, useMemo, useRef } from "react";
import { clock } from "../plots/clock";
import { binFor, type LineOf, RateTable } from "../plots/rates";
import { spikesOf, useSpikes } from "../plots/spikeStore";
import { valueText, xOf } from "../plots/timeAxis";
import { type Sheet, useCanvas } from "../plots/useCanvas";
import { scaleNow } from "../plots/useTimeNavigation";
import { useTimeWindow } from "../state/timeWindow";
import type { CellGroup, Population } from "../state/types";
import { Rarely, READABLE_MS } from "../ui/rarely";
import { Section } from "./Facts";

interface RateProps {
  group: CellGroup;
  /** The populations that its cells belong to. */
  populations: readonly Population[];
  cells: number;
}

/** The mean rate of the cells of a group over the common window of time. */
export function GroupRate({ group, populations, cells }: RateProps) {
  const highest = useRef<HTMLSpanElement>(null);
  const length_s = useTimeWindow((window) => window.length_s);
  const lines = useMemo(() => linesOf(group, populations), [group, populations]);
  const table = useMemo(() => new RateTable(length_s, binFor(length_s), [cells]), [length_s, cells]);
  useSpikes(populations);
  const { ref, redraw } = useCanvas((sheet) => {
    const scale = scaleNow(0, sheet.width);
    const rings = lines.map(({ label, lineOf }) => ({ ring: spikesOf(label), lineOf }));
    table.count(scale.from_s, rings);
    const most_hz = Math.max(table.highest_hz(0), 1e-9);
    paint(sheet, table, most_hz, (t_s) => xOf(scale, t_s));
    const text = `up to ${valueText(most_hz < 1e-6 ? 0 : most_hz)} Hz`;
    if (highest.current && highest.current.textContent !== text) highest.current.textContent = text;
  });
  useEffect(() => {
    const rarely = new Rarely(redraw, READABLE_MS);
    const leave = [clock.onTick(() => rarely.ask()), useTimeWindow.subscribe(redraw), () => rarely.stop()];
    return () => {
      for (const stop of leave) stop();
    };
  }, [redraw]);
  return (
    <Section title="Rate" note={<span ref={highest} />}>
      <canvas
        ref={ref}
        className="inspector-trace"
        role="img"
        aria-label={`Mean rate of the cells of ${group.name}`}
      />
    </Section>
  );
}

/** The cells of the group, for a table of one line. */
function linesOf(group: CellGroup, populations: readonly Population[]): { label: string; lineOf: LineOf }[] {
  return populations.map(({ label, size }) => {
    const lineOf = new Int32Array(size).fill(-1);
    for (const [from, to] of group.cells[label] ?? []) lineOf.fill(0, from, to);
    return { label, lineOf };
  });
}

function paint(
  { pen, height, colours }: Sheet,
  table: RateTable,
  most_hz: number,
  x: (t_s: number) => number,
): void {
  pen.fillStyle = colours.accent;
  for (let bin = table.first; bin < table.first + table.bins; bin++) {
    const [left, right] = [x(bin * table.bin_s), x((bin + 1) * table.bin_s)];
    pen.fillRect(left, height, right - left, (-table.rate_hz(0, bin) / most_hz) * (height - 2));
  }
}
