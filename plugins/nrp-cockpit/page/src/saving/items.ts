import { groupsOf } from "../plots/groups";
import { notify } from "../state/notices";
import { kindOf, type PanelId } from "../state/panels";
import { useRun } from "../state/run";
import { useTraces } from "../state/traces";
import type { MenuItem } from "../ui/Menu";
import { pngOf, svgOf } from "../ui/picture";
import { type Column, curvesCsv, spikesCsv } from "./csv";
import { download } from "./download";
import { endFilm, startFilm, useFilm } from "./film";
import { type Whole, wholeCurve, wholeSpikes } from "./whole";

/** What of a panel can be saved: items of its menu. */
export function savingItems(id: PanelId): MenuItem[] {
  const kind = kindOf(id);
  const items: MenuItem[] = [{ label: "Save as PNG", onSelect: () => void savePng(id) }];
  if (kind === "brain" && drawingIn(id)) items.push({ label: "Save as SVG", onSelect: () => saveSvg(id) });
  if (kind === "traces")
    items.push({ label: "Save as CSV", onSelect: () => void saveCsv(id, curvesOf(id), curvesCsv) });
  if (kind === "spikes")
    items.push({ label: "Save as CSV", onSelect: () => void saveCsv(id, allSpikes(), spikesCsv) });
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

/** Saves a table of all that the server knows, and says since when that is. */
async function saveCsv(id: PanelId, whole: Promise<Whole[]>, textsOf: (columns: Column[]) => string[]) {
  try {
    const columns = await whole;
    download(`${nameOf(id)}.csv`, new Blob(textsOf(columns), { type: "text/csv" }));
    const from_s = Math.max(0, ...columns.map((column) => column.from_s ?? 0));
    if (from_s > 0)
      notify(
        `The table begins at ${from_s.toFixed(2)} s; earlier values are not kept. A recording keeps all.`,
      );
  } catch (error) {
    notify((error as Error).message, "bad");
  }
}

function curvesOf(id: PanelId): Promise<Whole[]> {
  const { devices = [], topics = [] } = useRun.getState().experiment ?? {};
  const traces = useTraces.getState().traces.filter(({ panel = "traces" }) => panel === id);
  return Promise.all(
    groupsOf(traces, devices, topics).flatMap(({ title, curves }) =>
      curves.map(({ trace, label }) => wholeCurve(`${label}: ${title}`, trace)),
    ),
  );
}

const allSpikes = (): Promise<Whole[]> =>
  Promise.all((useRun.getState().experiment?.populations ?? []).map(({ label }) => wholeSpikes(label)));

function filmItem(id: PanelId): MenuItem {
  if (useFilm.getState().recorder) return { label: "End the video and save it", onSelect: endFilm };
  const canvas = bodyOf(id)?.querySelector("canvas");
  return {
    label: "Record a video",
    disabled: canvas && "MediaRecorder" in window ? undefined : "This browser records no video.",
    onSelect: () => canvas && startFilm(canvas, nameOf(id)),
  };
}
