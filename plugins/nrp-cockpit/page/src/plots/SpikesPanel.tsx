import { useEffect, useMemo, useRef, useState } from "react";
import { usePanelChoice } from "../state/panelChoices";
import { useRun } from "../state/run";
import { select, useSelection } from "../state/selection";
import type { CellGroup, Population } from "../state/types";
import { thousands } from "../ui/counts";
import { Empty, Panel } from "../ui/Panel";
import { Segmented } from "../ui/Segmented";
import { useRarely } from "../ui/useRarely";
import { CellsMenu } from "./CellsMenu";
import { clock } from "./clock";
import type { Order } from "./order";
import { PlotTable, type Row } from "./PlotTable";
import { heardOf, spikesOf, useSpikes } from "./spikeStore";
import { type Kind, type Look, SpikesPicture } from "./spikesPicture";
import { SPIKE_COLUMNS, spikeRow } from "./tables";
import { useCanvas } from "./useCanvas";
import { useMarks } from "./useMarks";
import { type LineNavigation, scaleNow, useTimeNavigation } from "./useTimeNavigation";
import { WindowTools } from "./WindowTools";
import "./plots.css";

const KINDS = [
  { value: "spikes", label: "Spikes" },
  { value: "rates", label: "Rates" },
  { value: "heat", label: "Heat" },
] as const;

const NONE: readonly Population[] = [];
const NO_GROUPS: readonly CellGroup[] = [];

/** Which cells are shown, and how; by default it depends on the brain whether a heat map shows groups or cells. */
interface Chosen {
  order: Order;
  each?: boolean;
}

/** What the raster does with the cells in sight; the menu does the same as wheel and drag. */
export type Zoom = (factor: number | null) => void;

/** The spikes of all populations over the common window of time, or their rates as bars or colours. */
export function SpikesPanel() {
  const populations = useRun((run) => run.experiment?.populations ?? NONE);
  const groups = useRun((run) => run.experiment?.groups ?? NO_GROUPS);
  const [kind, setKind] = usePanelChoice<Kind>("spikes");
  const [chosen, setLook] = useState<Chosen>({ order: "number" });
  const look = { kind, ...chosen, each: chosen.each ?? groups.length === 0 };
  const count = useRef<HTMLSpanElement>(null);
  const zoom = useRef<Zoom>(() => undefined);
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
    <Panel title="Spikes" sub={<span ref={count} className="spikes-count" />} tools={tools} className="plot">
      <Raster
        populations={populations}
        groups={groups}
        look={look}
        zoom={zoom}
        onCount={(text) => count.current?.replaceChildren(text)}
      />
      <CellsMenu
        look={look}
        onLook={({ order, each }) => setLook({ order, each })}
        onZoom={(factor) => zoom.current(factor)}
      />
    </Panel>
  );
}

interface RasterProps {
  populations: readonly Population[];
  groups: readonly CellGroup[];
  look: Look;
  /** Set to what zooms the cells. */
  zoom: { current: Zoom };
  /** Hears how many spikes there were lately. */
  onCount: (text: string) => void;
}

const COUNT_EVERY_MS = 300;

function Raster({ populations, groups, look, zoom, onCount }: RasterProps) {
  const devices = useRun((run) => run.experiment?.devices);
  const marks = useMarks();
  const selected = useSelection((state) => state.selected);
  const picture = useMemo(
    () => new SpikesPicture(populations, groups, devices ?? []),
    [populations, groups, devices],
  );
  const scale = useRef(picture.scale);
  const counted = useRarely(COUNT_EVERY_MS, () =>
    onCount(countText(populations) + (look.order === "active" ? activeText(picture.shown) : "")),
  );
  useSpikes(populations);

  const { ref, redraw } = useCanvas((sheet) => {
    picture.paint(sheet, look, marks, selected);
    scale.current = picture.scale;
    counted.ask();
  });
  const lines = useMemo((): LineNavigation => {
    const changed = (change: () => void) => {
      change();
      redraw();
    };
    return {
      press: (y, beside) => select(picture.at(y, beside)),
      zoom: (y, factor) => changed(() => picture.zoom(factor, y)),
      grab: () => {
        const from = picture.inSight;
        return (dy) => changed(() => picture.pull(from, dy));
      },
      reset: () => changed(() => picture.showAll()),
    };
  }, [picture, redraw]);
  useEffect(() => {
    zoom.current = (factor) => {
      if (factor === null) picture.showAll();
      else picture.zoom(factor);
      redraw();
    };
  }, [zoom, picture, redraw]);
  const handlers = useTimeNavigation(ref, scale, redraw, lines);
  const names = populations.map(({ label }) => label).join(", ");
  return (
    <>
      <canvas
        ref={ref}
        className="plot-canvas"
        role="img"
        aria-label={`Spikes of ${names}`}
        data-y={look.kind === "rates" ? "Rate (Hz)" : "Neuron"}
        {...handlers}
      />
      <PlotTable
        caption={`Spikes of ${names}`}
        columns={SPIKE_COLUMNS}
        rows={() => populations.map(rowNow)}
      />
    </>
  );
}

function rowNow(population: Population): Row {
  const { from_s, to_s } = scaleNow(0, 1);
  const { label } = population;
  const until_s = Math.min(to_s, clock.now_s);
  return spikeRow(population, spikesOf(label), heardOf(label), Math.max(0, from_s), until_s);
}

const activeText = (cells: number) => `, of ${thousands(cells)} cells in sight`;

function countText(populations: readonly Population[]): string {
  const from_s = Math.max(0, clock.now_s - 1);
  const isHeard = ({ label }: Population) =>
    heardOf(label).has(clock.now_s) && heardOf(label).gaps(from_s, clock.now_s).length === 0;
  if (clock.now_s <= 0 || !populations.every(isHeard)) return "– in 1 s";
  const count = populations.reduce((sum, { label }) => {
    const spikes = spikesOf(label);
    return sum + spikes.length - spikes.indexAt(clock.now_s - 1);
  }, 0);
  return `${count} in ${Number((clock.now_s - from_s).toFixed(2))} s`;
}
