import { useCallback, useMemo, useRef } from "react";
import { usePanelChoice } from "../state/panelChoices";
import { useRun } from "../state/run";
import { select, useSelection } from "../state/selection";
import type { Population } from "../state/types";
import { Empty, Panel } from "../ui/Panel";
import { Segmented } from "../ui/Segmented";
import { clock } from "./clock";
import { heardOf, spikesOf, useSpikes } from "./spikeStore";
import { type Kind, SpikesPicture } from "./spikesPicture";
import { useCanvas } from "./useCanvas";
import { useTimeNavigation } from "./useTimeNavigation";
import { WindowTools } from "./WindowTools";
import "./plots.css";

const KINDS = [
  { value: "spikes", label: "Spikes" },
  { value: "rates", label: "Rates" },
] as const;

const NONE: readonly Population[] = [];

/** The spikes of all populations over the common window of time, or their mean rates. */
export function SpikesPanel() {
  const populations = useRun((run) => run.experiment?.populations ?? NONE);
  const [kind, setKind] = usePanelChoice<Kind>("spikes");
  const count = useRef<HTMLSpanElement>(null);
  const tools = (
    <>
      <Segmented label="Kind of plot" choices={KINDS} value={kind} onChange={setKind} />
      <WindowTools plot="spikes" />
    </>
  );
  if (populations.length === 0)
    return (
      <Panel title="Spikes">
        <Empty>Waiting for the populations.</Empty>
      </Panel>
    );
  return (
    <Panel title="Spikes" sub={<span ref={count} />} tools={tools} className="plot">
      <Raster
        populations={populations}
        kind={kind}
        onCount={(text) => count.current?.replaceChildren(text)}
      />
    </Panel>
  );
}

interface RasterProps {
  populations: readonly Population[];
  kind: Kind;
  /** Hears how many spikes there were lately. */
  onCount: (text: string) => void;
}

const COUNT_EVERY_MS = 300;

function Raster({ populations, kind, onCount }: RasterProps) {
  const devices = useRun((run) => run.experiment?.devices);
  const events = useRun((run) => run.timeline?.events);
  const selected = useSelection((state) => state.selected);
  const picture = useMemo(() => new SpikesPicture(populations, devices ?? []), [populations, devices]);
  const scale = useRef(picture.scale);
  const counted = useRef(0);
  useSpikes(populations);

  const { ref, redraw } = useCanvas((sheet) => {
    picture.paint(sheet, kind, events ?? [], selected);
    scale.current = picture.scale;
    if (performance.now() - counted.current < COUNT_EVERY_MS) return;
    counted.current = performance.now();
    onCount(countText(populations));
  });
  const press = useCallback((y: number) => select(picture.at(y)), [picture]);
  const handlers = useTimeNavigation(ref, scale, redraw, press);
  const names = populations.map(({ label }) => label).join(", ");
  return (
    <canvas ref={ref} className="plot-canvas" role="img" aria-label={`Spikes of ${names}`} {...handlers} />
  );
}

function countText(populations: readonly Population[]): string {
  const from_s = Math.max(0, clock.now_s - 1);
  const isHeard = ({ label }: Population) =>
    heardOf(label).has(clock.now_s) && heardOf(label).gaps(from_s, clock.now_s).length === 0;
  if (!populations.every(isHeard)) return "– in the last second";
  const count = populations.reduce((sum, { label }) => {
    const spikes = spikesOf(label);
    return sum + spikes.length - spikes.indexAt(clock.now_s - 1);
  }, 0);
  return `${count} in the last second`;
}
