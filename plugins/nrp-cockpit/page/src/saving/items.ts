import { groupsOf } from "../plots/groups";
import { notify } from "../state/notices";
import { kindOf, type PanelId } from "../state/panels";
import { useRun } from "../state/run";
import { useTraces } from "../state/traces";
import type { MenuItem } from "../ui/Menu";
import { pngOf, rasterized } from "../ui/picture";
import { type Column, curvesCsv, spikesCsv } from "./csv";
import { download } from "./download";
import { canBeFigure, figureOf, PRINT_DPI, PX_PER_INCH, pxOf, WIDTHS_MM } from "./figure";
import { endFilm, startFilm, useFilm } from "./film";
import { withResolution } from "./png";
import { type Whole, wholeCurve, wholeSpikes } from "./whole";

/** What of a panel can be saved: items of its menu. */
export function savingItems(id: PanelId): MenuItem[] {
  const kind = kindOf(id);
  const body = bodyOf(id);
  const items = body ? pictureItems(body, () => nameOf(id)) : [];
  if (kind === "traces")
    items.push({ label: "Save as CSV", onSelect: () => void saveCsv(id, curvesOf(id), curvesCsv) });
  if (kind === "spikes")
    items.push({ label: "Save as CSV", onSelect: () => void saveCsv(id, allSpikes(), spikesCsv) });
  if (kind === "scene") items.push(filmItem(id));
  return items;
}

const bodyOf = (id: PanelId) =>
  document.querySelector<HTMLElement>(`.frame[data-panel="${id}"] > .panel > .panel-body`);

/** The name of a file without its ending: the run, the panel and the simulated time. */
function nameOf(id: PanelId): string {
  const { experiment, status } = useRun.getState();
  return [experiment?.name ?? "run", id.replace(" ", "-"), `${(status?.t_s ?? 0).toFixed(2)}s`].join("-");
}

/** Items that save what an element shows at the widths of a journal's columns. */
export function pictureItems(body: HTMLElement, name: () => string): MenuItem[] {
  const formats = canBeFigure(body) ? (["SVG", "PNG"] as const) : (["PNG"] as const);
  return formats.flatMap((format) =>
    WIDTHS_MM.map((width_mm) => ({
      label: `Save as ${format}, ${width_mm} mm wide`,
      onSelect: () => void savePicture(body, name(), format, width_mm),
    })),
  );
}

async function savePicture(body: HTMLElement, name: string, format: "SVG" | "PNG", width_mm: number) {
  const figure = figureOf(body, width_mm);
  const dots = PRINT_DPI / PX_PER_INCH;
  try {
    if (figure && format === "SVG")
      return download(`${name}.svg`, new Blob([figure.svg], { type: "image/svg+xml" }));
    const png = figure
      ? rasterized(figure.svg, figure.width * dots, figure.height * dots)
      : pngOf(body, pxOf(width_mm) * dots);
    download(`${name}.png`, withResolution(await png, PRINT_DPI));
  } catch (error) {
    notify((error as Error).message, "bad");
  }
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
