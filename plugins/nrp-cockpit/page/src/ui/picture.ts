/** The event by which a canvas of WebGL draws at once, with `detail` pixels a CSS pixel: they are gone after the frame. */
export const REPAINT = "repaint";

const XHTML = "http://www.w3.org/1999/xhtml";
const SVG = "http://www.w3.org/2000/svg";

/** Controls that have no place in a picture. */
const HIDDEN =
  ".scene-hint, .plot-cells, .trace-key > button, .hidden-text, .plot-table { display: none !important; }";

/** Returns all contents of a panel, drawn as on the screen but without its controls, as PNG of a width in pixels. */
export function pngOf(body: HTMLElement, wide: number): Promise<Blob> {
  const { width } = body.getBoundingClientRect();
  const height = body.scrollHeight; // also what is out of sight
  const ratio = wide / width;
  return rasterized(drawingOf(body, width, height, ratio), wide, height * ratio);
}

/** Returns a drawing in SVG as PNG of a size in pixels. */
export async function rasterized(svg: string, width: number, height: number): Promise<Blob> {
  const image = await loaded(svg);
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [Math.round(width), Math.round(height)];
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
function drawingOf(body: HTMLElement, width: number, height: number, ratio: number): string {
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
  frame.append(style, withPictures(body, ratio));
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

/** A copy in which the canvases are images, of so many pixels a CSS pixel where they can be drawn again. */
function withPictures(body: HTMLElement, ratio: number): HTMLElement {
  const copy = body.cloneNode(true) as HTMLElement;
  copy.style.height = "100%";
  const canvases = [...copy.querySelectorAll("canvas")];
  [...body.querySelectorAll("canvas")].forEach((canvas, at) => {
    canvas.dispatchEvent(new CustomEvent(REPAINT, { detail: ratio }));
    const image = document.createElement("img");
    const { width, height } = canvas.getBoundingClientRect();
    image.className = canvas.className;
    image.setAttribute("style", `width: ${width}px; height: ${height}px`);
    image.src = canvas.toDataURL();
    canvas.dispatchEvent(new CustomEvent(REPAINT));
    canvases[at]?.replaceWith(image);
  });
  return copy;
}

/** What other programs need to know of an element; they do not read the style sheets of the page. */
const DRAWN = [
  "fill", "stroke", "stroke-width", "stroke-dasharray", "opacity", "fill-opacity", "stroke-opacity", "display",
  "font-family", "font-size", "font-weight", "text-anchor", "marker-end", "paint-order",
]; // biome-ignore format: a list

/** Returns the elements of a drawing of the page, with what its style sheets say of them. */
export function elementsOf(drawing: SVGSVGElement): string {
  const copy = drawing.cloneNode(true) as SVGSVGElement;
  const copies = [...copy.querySelectorAll("*")];
  [...drawing.querySelectorAll("*")].forEach((one, at) => {
    const style = getComputedStyle(one);
    const text = DRAWN.map((name) => `${name}: ${style.getPropertyValue(name)}`).join("; ");
    copies[at]?.setAttribute("style", text);
    const scale = new DOMMatrix(style.transform).a; // few programs know what CSS transforms
    if (one instanceof SVGRectElement && scale !== 1)
      copies[at]?.setAttribute("width", String(scale * one.width.baseVal.value));
  });
  return [...copy.children].map((one) => new XMLSerializer().serializeToString(one)).join("\n");
}
