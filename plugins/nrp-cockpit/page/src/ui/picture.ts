/** The event by which a canvas of WebGL draws at once: its pixels are gone after the frame. */
export const REPAINT = "repaint";

/** Device pixels a CSS pixel, enough for print. */
const RATIO = 2;
const XHTML = "http://www.w3.org/1999/xhtml";
const SVG = "http://www.w3.org/2000/svg";

/** Controls that have no place in a picture. */
const HIDDEN =
  ".scene-hint, .plot-cells, .trace-key > button, .hidden-text, .plot-table { display: none !important; }";

/** Returns all contents of a panel, drawn as on the screen but without its controls, as PNG. */
export async function pngOf(body: HTMLElement): Promise<Blob> {
  const { width } = body.getBoundingClientRect();
  const height = body.scrollHeight; // also what is out of sight
  const image = await loaded(drawingOf(body, width, height));
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [Math.round(width * RATIO), Math.round(height * RATIO)];
  canvas.getContext("2d")?.drawImage(image, 0, 0, canvas.width, canvas.height);
  return new Promise((done, fail) =>
    canvas.toBlob((blob) => (blob ? done(blob) : fail(new Error("The browser makes no picture of it.")))),
  );
}

function loaded(svg: string): Promise<HTMLImageElement> {
  return new Promise((done, fail) => {
    const image = new Image();
    image.onload = () => done(image);
    image.onerror = () => fail(new Error("The browser makes no picture of it."));
    image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(svg)}`;
  });
}

/** The elements with all styles of the page, which a browser draws as it draws the page. */
function drawingOf(body: HTMLElement, width: number, height: number): string {
  const root = document.createElementNS(SVG, "svg");
  const inside = document.createElementNS(SVG, "foreignObject");
  for (const one of [root, inside]) {
    one.setAttribute("width", String(width));
    one.setAttribute("height", String(height));
  }
  const style = document.createElementNS(XHTML, "style");
  style.textContent = `${stylesOfPage()}\n${HIDDEN}`;
  const frame = document.createElement("div");
  frame.className = `${document.documentElement.className} frame`;
  frame.setAttribute("style", pageStyle(width, height));
  frame.append(style, withPictures(body));
  inside.append(frame);
  root.append(inside);
  return new XMLSerializer().serializeToString(root);
}

const stylesOfPage = () =>
  [...document.styleSheets].flatMap(({ cssRules }) => [...cssRules].map(({ cssText }) => cssText)).join("\n");

/** What the page gives its elements by inheritance. */
function pageStyle(width: number, height: number): string {
  const { fontFamily, fontSize, lineHeight, color } = getComputedStyle(document.body);
  const font = `font-family: ${fontFamily}; font-size: ${fontSize}; line-height: ${lineHeight}`;
  return `width: ${width}px; height: ${height}px; ${font}; color: ${color}; background: var(--panel)`;
}

/** A copy in which the canvases are images. */
function withPictures(body: HTMLElement): HTMLElement {
  const copy = body.cloneNode(true) as HTMLElement;
  copy.style.height = "100%";
  const canvases = [...copy.querySelectorAll("canvas")];
  [...body.querySelectorAll("canvas")].forEach((canvas, at) => {
    canvas.dispatchEvent(new Event(REPAINT));
    const image = document.createElement("img");
    const { width, height } = canvas.getBoundingClientRect();
    image.className = canvas.className;
    image.setAttribute("style", `width: ${width}px; height: ${height}px`);
    image.src = canvas.toDataURL();
    canvases[at]?.replaceWith(image);
  });
  return copy;
}

/** What other programs need to know of an element; they do not read the style sheets of the page. */
const DRAWN = [
  "fill", "stroke", "stroke-width", "stroke-dasharray", "opacity", "fill-opacity", "stroke-opacity", "display",
  "font-family", "font-size", "font-weight", "text-anchor", "dominant-baseline", "marker-end", "paint-order",
]; // biome-ignore format: a list

/** Returns a drawing of the page as a file of its own. */
export function svgOf(drawing: SVGSVGElement): Blob {
  const copy = drawing.cloneNode(true) as SVGSVGElement;
  const { width, height } = drawing.getBoundingClientRect();
  const copies = [...copy.querySelectorAll("*")];
  [...drawing.querySelectorAll("*")].forEach((one, at) => {
    const style = getComputedStyle(one);
    const text = DRAWN.map((name) => `${name}: ${style.getPropertyValue(name)}`).join("; ");
    copies[at]?.setAttribute("style", text);
  });
  copy.setAttribute("width", String(width));
  copy.setAttribute("height", String(height));
  copy.setAttribute("xmlns", SVG);
  return new Blob([new XMLSerializer().serializeToString(copy)], { type: "image/svg+xml" });
}
