import { kindOf, type PanelId } from "../layout/tree";
import { groupsOf } from "../plots/groups";
import { spikesOf } from "../plots/spikeStore";
import { valuesOf } from "../plots/traceStore";
import { notify } from "../state/notices";
import { useRun } from "../state/run";
import { useTraces } from "../state/traces";
import type { MenuItem } from "../ui/Menu";
import { curvesCsv, spikesCsv } from "./csv";
import { download } from "./download";
import { endFilm, startFilm, useFilm } from "./film";
import { pngOf, svgOf } from "./picture";

/** What of a panel can be saved: items of its menu. */
export function savingItems(id: PanelId): MenuItem[] {
  const kind = kindOf(id);
  const items: MenuItem[] = [{ label: "Save as PNG", onSelect: () => void savePng(id) }];
  if (kind === "brain" && drawingIn(id)) items.push({ label: "Save as SVG", onSelect: () => saveSvg(id) });
  if (kind === "traces") items.push({ label: "Save as CSV", onSelect: () => saveCurves(id) });
  if (kind === "spikes") items.push({ label: "Save as CSV", onSelect: saveSpikes });
  if (kind === "scene") items.push(filmItem(id));
  return items;
}

const bodyOf = (id: PanelId) =>
  document.querySelector<HTMLElement>(`.frame[data-panel="${id}"] > .panel > .panel-body`);
const drawingIn = (id: PanelId) => bodyOf(id)?.querySelector<SVGSVGElement>("svg.brain-graph");

/** The name of a file without its ending: the run, the panel and the simulated time. */
function nameOf(id: PanelId): string {
  const { experiment, status } = useRun.getState();
  return [experiment?.name ?? "run", id.replace(" ", "-"), `${(status?.t_s ?? 0).toFixed(2)}s`].join("-");
}

async function savePng(id: PanelId): Promise<void> {
  const body = bodyOf(id);
  if (!body) return;
  try {
    download(`${nameOf(id)}.png`, await pngOf(body));
  } catch (error) {
    notify((error as Error).message, "bad");
  }
}

function saveSvg(id: PanelId): void {
  const drawing = drawingIn(id);
  if (drawing) download(`${nameOf(id)}.svg`, svgOf(drawing));
}

const saveCsv = (id: PanelId, text: string) =>
  download(`${nameOf(id)}.csv`, new Blob([text], { type: "text/csv" }));

function saveCurves(id: PanelId): void {
  const { devices = [], topics = [] } = useRun.getState().experiment ?? {};
  const traces = useTraces.getState().traces.filter(({ panel = "traces" }) => panel === id);
  const columns = groupsOf(traces, devices, topics).flatMap(({ title, curves }) =>
    curves.map(({ trace, label }) => ({ name: `${label}: ${title}`, values: valuesOf(trace) })),
  );
  saveCsv(id, curvesCsv(columns));
}

function saveSpikes(): void {
  const populations = useRun.getState().experiment?.populations ?? [];
  saveCsv("spikes", spikesCsv(populations.map(({ label }) => ({ name: label, values: spikesOf(label) }))));
}

function filmItem(id: PanelId): MenuItem {
  if (useFilm.getState().recorder) return { label: "End the video and save it", onSelect: endFilm };
  const canvas = bodyOf(id)?.querySelector("canvas");
  return {
    label: "Record a video",
    disabled: canvas && "MediaRecorder" in window ? undefined : "This browser records no video.",
    onSelect: () => canvas && startFilm(canvas, nameOf(id)),
  };
}
