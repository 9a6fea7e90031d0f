import { type Role, rolesOf } from "../state/cells";
import { type Grouping, groupingOf } from "../state/grouping";
import type { Selection } from "../state/selection";
import type { CellGroup, Device, Population } from "../state/types";
import { clock } from "./clock";
import { bandsOf, type Order, type Ordered } from "./order";
import type { Palette } from "./palette";
import { drawCursors, drawEvents, drawTimeAxis, MARGIN, setFont } from "./pen";
import { ALL, type Sight, shifted, zoomed } from "./raster";
import { RasterPicture } from "./rasterPicture";
import { drawBorders, drawNames, drawSelected, drawUnheard, layRows, type Row, shownAt, TOP } from "./rows";
import { spikesOf } from "./spikeStore";
import { TablePicture } from "./tablePicture";
import type { TimeScale } from "./timeAxis";
import type { Sheet } from "./useCanvas";
import { scaleNow } from "./useTimeNavigation";

export type Kind = "spikes" | "rates" | "heat";

/** What is drawn of the spikes. */
export interface Look {
  kind: Kind;
  order: Order;
  /** Whether a heat map has a line for each cell, as far as there is height for it, or one for each band. */
  each: boolean;
}

interface Event {
  name: string;
  t_s: number | null;
}

/** The active cells are looked for this often (ms of wall time): lines that jump all the time cannot be read. */
const ORDER_MS = 2000;

/** Paints bands of cells below each other: their spikes, histograms of their rates, or rates as colours. */
export class SpikesPicture {
  scale: TimeScale = { from_s: 0, to_s: 1, left: 0, right: 1 };
  private sight = ALL;
  private rows: Row[] = [];
  private height = 1;
  private ratio = 1;
  private look: Look | null = null;
  private bands: Ordered[] = [];
  private ordered_ms = 0;
  private readonly roles: ReadonlyMap<string, Role[]>;
  private readonly groupings: readonly Grouping[];
  private raster: RasterPicture | null = null;
  private table: TablePicture | null = null;
  private drawnAs = "";
  private inked: Palette | null = null;

  constructor(
    private readonly populations: readonly Population[],
    groups: readonly CellGroup[],
    devices: readonly Device[],
  ) {
    this.roles = new Map(populations.map((one) => [one.label, rolesOf(one, devices)]));
    this.groupings = populations.map((population) => groupingOf(population, groups));
  }

  /** How many cells have a line of their own or share one. */
  get shown(): number {
    return this.bands.reduce((sum, { cells }) => sum + cells.length, 0);
  }

  paint(sheet: Sheet, look: Look, events: readonly Event[], selected: Selection | null): void {
    const bottom = sheet.height - MARGIN.bottom;
    this.scale = scaleNow(MARGIN.left, sheet.width - MARGIN.right);
    if (bottom - TOP < 8 || this.scale.right - this.scale.left < 8) return;
    this.arrange(sheet, look);
    const { scale, rows } = this;
    setFont(sheet);
    for (const row of rows) {
      if (selected) drawSelected(sheet, scale, row, selected);
      drawUnheard(sheet, scale, row, clock.now_s);
    }
    if (this.isNamed) drawBorders(sheet, scale, rows);
    drawTimeAxis(sheet, scale, TOP, bottom);
    const names = look.kind === "heat" ? {} : { names: TOP / 2 };
    this.paintCells(sheet, look);
    drawEvents(sheet, scale, events, { top: TOP, bottom, ...names });
    drawCursors(sheet, scale, clock.now_s, TOP, bottom);
    drawNames(sheet, rows, look.kind === "spikes" || (look.kind === "heat" && look.each));
  }

  /** What is shown at a height; beside it a band has its name. */
  at(y: number, beside: boolean): Selection | null {
    const single = this.look?.kind === "spikes" || (this.look?.kind === "heat" && this.look.each);
    return shownAt(this.rows, y, this.ratio, single && !(beside && this.isNamed));
  }

  /** Shows fewer cells, or more, around the one at a height, or in the middle. */
  zoom(factor: number, y = TOP + this.height / this.ratio / 2): void {
    const at = Math.min(1, Math.max(0, ((y - TOP) * this.ratio) / this.height));
    this.sight = zoomed(this.sight, at, factor, this.shown, this.height);
  }

  /** Moves the cells in sight by some pixels. */
  pull(from: Sight, dy: number): void {
    this.sight = shifted(from, (-dy * this.ratio * (from.to - from.from)) / this.height);
  }

  /** Whether there are more bands than populations, whose names are written beside them. */
  private get isNamed(): boolean {
    return this.bands.length > this.populations.length;
  }

  get inSight(): Sight {
    return this.sight;
  }

  showAll(): void {
    this.sight = ALL;
  }

  /** Lays out what is drawn, unless it is laid out like this already. */
  private arrange({ height, width, ratio, colours }: Sheet, look: Look): void {
    const orders = this.orders(look);
    this.height = Math.floor((height - MARGIN.bottom - TOP) * ratio);
    this.ratio = ratio;
    this.look = look;
    const { from, to } = this.sight;
    const length_s = Math.round((this.scale.to_s - this.scale.from_s) * 1e9) / 1e9;
    const as = [look.kind, look.order, look.each, this.height, width, ratio, from, to, length_s].join();
    if (as === this.drawnAs && colours === this.inked && !orders) return;
    this.drawnAs = as;
    this.inked = colours;
    this.rows = layRows(this.bands, (label) => this.roles.get(label) ?? [], this.height, ratio, this.sight);
    const wide = Math.round((this.scale.right - this.scale.left) * ratio);
    this.raster = this.table = null;
    if (look.kind === "spikes")
      this.raster = new RasterPicture(wide, this.height, wide / length_s, this.rows, colours);
    else
      this.table = new TablePicture(
        length_s,
        this.rows,
        this.height,
        ratio,
        look.kind === "heat" && look.each,
      );
  }

  /** Orders the cells, if it is time to, and returns whether their order is a new one. */
  private orders({ order }: Look): boolean {
    const since_ms = performance.now() - this.ordered_ms;
    const isSame = order === this.look?.order && (order === "number" || since_ms < ORDER_MS);
    if (isSame) return false;
    this.ordered_ms = performance.now();
    const counts = this.populations.map((population) =>
      order === "active" ? countsOf(population, this.scale) : null,
    );
    const anyActive = counts.some((each) => each?.some((count) => count > 0));
    const next = this.populations.flatMap((population, at) =>
      bandsOf(population, this.groupings[at] as Grouping, anyActive ? (counts[at] ?? null) : null),
    );
    const isNew =
      next.length !== this.bands.length || next.some((band, at) => !sameCells(band, this.bands[at]));
    this.bands = next;
    return isNew;
  }

  private paintCells(sheet: Sheet, { kind }: Look): void {
    const { scale } = this;
    if (sheet.figure) this.raster?.stroke(sheet, scale);
    else this.raster?.paint(sheet, scale.left, scale.from_s);
    this.table?.count(scale.from_s);
    if (kind === "rates") this.table?.paintBars(sheet, scale);
    if (kind === "heat") this.table?.paintColours(sheet, scale);
  }
}

/** How often each cell fired in a window. */
function countsOf({ label, size }: Population, { from_s, to_s }: TimeScale): Uint32Array {
  const counts = new Uint32Array(size);
  spikesOf(label).visit(from_s, to_s, (_, cell) => {
    counts[cell] = (counts[cell] ?? 0) + 1;
  });
  return counts;
}

const sameCells = (a: Ordered, b: Ordered | undefined): boolean =>
  a.label === b?.label &&
  a.cells.length === b.cells.length &&
  a.cells.every((cell, at) => cell === b.cells[at]);
