import { readPalette } from "../plots/palette";
import { MARGIN } from "../plots/pen";
import { SvgPen } from "../plots/svgPen";
import { painterOf, type Sheet } from "../plots/useCanvas";
import { elementsOf } from "../ui/picture";

/** The widths of one and of two columns of most journals. */
export const WIDTHS_MM = [85, 180] as const;
const MM_PER_INCH = 25.4;
/** What CSS and SVG call a pixel. */
export const PX_PER_INCH = 96;
/** The resolution that journals ask for. */
export const PRINT_DPI = 300;

/** A drawing for print; sizes in CSS pixels. */
export interface Figure {
  svg: string;
  width: number;
  height: number;
}

const FONT_PX = 10;
const FAMILY = 'Arial, Helvetica, "Liberation Sans", "DejaVu Sans", sans-serif';
const FONT = `${FONT_PX}px ${FAMILY}`;
/** The height of the name of an axis. */
const NAME_PX = 14;
const LEAST_PX = 120;
/** No plot is higher than this part of its width. */
const HIGHEST = 0.6;

export const pxOf = (width_mm: number): number => (width_mm / MM_PER_INCH) * PX_PER_INCH;

/** Draws what a panel shows as a figure of a width; null if it is not a plot, a map or a graph. */
export function figureOf(body: HTMLElement, width_mm: number): Figure | null {
  const graph = body.querySelector<SVGSVGElement>("svg.brain-graph");
  const canvases = [...body.querySelectorAll("canvas")].filter(painterOf);
  return inLight(() => (graph ? graphFigure(graph, width_mm) : plotFigure(canvases, width_mm)));
}

export const canBeFigure = (body: HTMLElement): boolean =>
  body.querySelector("svg.brain-graph") !== null || [...body.querySelectorAll("canvas")].some(painterOf);

/** Calls with the colours of the light theme: paper is white. */
function inLight<T>(draw: () => T): T {
  const { classList } = document.documentElement;
  const isDark = classList.replace("theme-dark", "theme-light");
  try {
    return draw();
  } finally {
    if (isDark) classList.replace("theme-light", "theme-dark");
  }
}

function graphFigure(graph: SVGSVGElement, width_mm: number): Figure {
  const { width, height } = graph.getBoundingClientRect();
  return wrap(elementsOf(graph), { width, height }, width_mm);
}

function plotFigure(canvases: readonly HTMLCanvasElement[], width_mm: number): Figure | null {
  if (canvases.length === 0) return null;
  const pen = new SvgPen(FONT);
  const colours = { ...readPalette(), font: FONT };
  const width = pxOf(width_mm);
  let top = 0;
  for (const canvas of canvases) {
    top += drawLegend({ pen, colours, width, height: 0, ratio: 1 }, canvas, top);
    const { clientWidth, clientHeight } = canvas;
    const isMap = canvas.dataset.y === undefined;
    const height = isMap
      ? (width * clientHeight) / clientWidth
      : Math.max(LEAST_PX, Math.min(clientHeight, HIGHEST * width));
    drawCanvas({ pen, colours, width, height, ratio: 4, figure: true }, canvas, top);
    top += height;
  }
  if (canvases[0]?.dataset.y !== undefined) {
    Object.assign(pen, { fillStyle: colours.text, textAlign: "center", textBaseline: "middle" });
    pen.fillText("Time (s)", (width + NAME_PX + MARGIN.left - MARGIN.right) / 2, top + NAME_PX / 2);
    top += NAME_PX + 2;
  }
  return wrap(pen.drawn, { width, height: top }, width_mm);
}

/** Draws a canvas below a height, with the name of its values on the left. */
function drawCanvas(sheet: Sheet, canvas: HTMLCanvasElement, top: number): void {
  const { pen, colours, width, height } = sheet;
  const name = canvas.dataset.y;
  pen.save();
  if (name) {
    pen.save();
    pen.translate(NAME_PX / 2, top + (height - MARGIN.bottom) / 2);
    pen.rotate(-Math.PI / 2);
    Object.assign(pen, { font: FONT, fillStyle: colours.text, textAlign: "center", textBaseline: "middle" });
    pen.fillText(name, 0, 0);
    pen.restore();
  }
  const left = name ? NAME_PX : 0;
  pen.translate(left, top);
  const painter = painterOf(canvas);
  painter?.paint({ ...sheet, width: width - left });
  painter?.redraw();
  pen.restore();
}

/** Draws the names of the curves of a canvas in their colours, in as many lines as they need; returns their height. */
function drawLegend({ pen, colours, width }: Sheet, canvas: HTMLCanvasElement, top: number): number {
  const entries = [...(canvas.closest("section.trace-group")?.querySelectorAll(".trace-key") ?? [])];
  if (entries.length === 0) return 0;
  const begin = NAME_PX + MARGIN.left;
  let [x, y] = [begin, top + NAME_PX / 2];
  Object.assign(pen, { font: FONT, textAlign: "left", textBaseline: "middle", lineWidth: 1.5 });
  for (const entry of entries) {
    const name = entry.querySelector("span")?.textContent ?? "";
    const wide = 16 + pen.measureText(name).width;
    if (x > begin && x + wide > width) [x, y] = [begin, y + NAME_PX];
    const sample = entry.querySelector("i");
    pen.strokeStyle = sample ? getComputedStyle(sample).getPropertyValue("--c") : colours.text;
    pen.beginPath();
    pen.moveTo(x, y);
    pen.lineTo(x + 12, y);
    pen.stroke();
    pen.fillStyle = colours.text;
    pen.fillText(name, x + 16, y);
    x += wide + 12;
  }
  return y + NAME_PX / 2 - top;
}

/** The elements as a file whose width other programs read in millimetres. */
function wrap(elements: string, { width, height }: Omit<Figure, "svg">, width_mm: number): Figure {
  const height_mm = Math.round(((width_mm * height) / width) * 100) / 100;
  const box = `viewBox="0 0 ${width.toFixed(2)} ${height.toFixed(2)}"`;
  const head = `<svg xmlns="http://www.w3.org/2000/svg" width="${width_mm}mm" height="${height_mm}mm" ${box}`;
  const font = `font-family="${FAMILY.replaceAll('"', "'")}" font-size="${FONT_PX}"`;
  const svg = `${head} ${font}><rect width="100%" height="100%" fill="#ffffff"/>\n${elements}\n</svg>\n`;
  return { svg, width: pxOf(width_mm), height: pxOf(height_mm) };
}
