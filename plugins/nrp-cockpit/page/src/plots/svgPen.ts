import type { Pen } from "./useCanvas";

/** The share of the font size by which the baseline is below the given point, by `textBaseline`. */
const BELOW = { middle: 0.35, top: 0.8, alphabetic: 0 } as const;
const ANCHORS = { left: "start", center: "middle", right: "end" } as const;
/** Images are made finer by this, so that programs that smooth them do not blur their pixels. */
const FINER = 4;

type State = Pick<
  SvgPen,
  "strokeStyle" | "fillStyle" | "lineWidth" | "lineJoin" | "lineCap" | "globalAlpha"
> & {
  matrix: DOMMatrix;
  clipped: string;
};

/** Draws as the pen of a canvas does, into elements of SVG with plain attributes that other programs read. */
export class SvgPen implements Pen {
  strokeStyle = "#000000";
  fillStyle = "#000000";
  lineWidth = 1;
  lineJoin: CanvasLineJoin = "miter";
  lineCap: CanvasLineCap = "butt";
  globalAlpha = 1;
  textAlign: keyof typeof ANCHORS = "left";
  textBaseline: keyof typeof BELOW = "alphabetic";
  imageSmoothingEnabled = false;
  private readonly measuring = document.createElement("canvas").getContext("2d");
  private readonly elements: string[] = [];
  private readonly states: State[] = [];
  private matrix = new DOMMatrix();
  private clipped = "";
  private clips = 0;
  private dashes = "";
  private path = "";
  /** The last path and its attributes: paths that look alike become one element. */
  private last = { path: "", attributes: "" };

  /** `font`: as CSS has it, such as `11px Arial`. */
  constructor(public font: string) {}

  /** The elements that were drawn. */
  get drawn(): string {
    this.add("");
    return this.elements.join("\n");
  }

  save(): void {
    const { strokeStyle, fillStyle, lineWidth, lineJoin, lineCap, globalAlpha, matrix, clipped } = this;
    this.states.push({
      ...{ strokeStyle, fillStyle, lineWidth, lineJoin, lineCap, globalAlpha, clipped },
      matrix: DOMMatrix.fromMatrix(matrix),
    });
  }

  restore(): void {
    Object.assign(this, this.states.pop());
  }

  translate(x: number, y: number): void {
    this.matrix.translateSelf(x, y);
  }

  rotate(angle: number): void {
    this.matrix.rotateSelf((angle * 180) / Math.PI);
  }

  setLineDash(dashes: number[]): void {
    this.dashes = dashes.join(" ");
  }

  beginPath(): void {
    this.path = "";
  }

  closePath(): void {
    this.path += "Z";
  }

  moveTo(x: number, y: number): void {
    this.path += `M${this.place(x, y)}`;
  }

  lineTo(x: number, y: number): void {
    this.path += `${this.path === "" ? "M" : "L"}${this.place(x, y)}`;
  }

  rect(x: number, y: number, width: number, height: number): void {
    this.path += this.rectangle(x, y, width, height);
  }

  fill(): void {
    this.draw(this.path, paint("fill", this.fillStyle, this.globalAlpha));
  }

  stroke(): void {
    this.draw(this.path, this.lines());
  }

  fillRect(x: number, y: number, width: number, height: number): void {
    const rectangle = this.rectangle(x, y, width, height);
    this.draw(rectangle, paint("fill", this.fillStyle, this.globalAlpha));
  }

  strokeRect(x: number, y: number, width: number, height: number): void {
    this.draw(this.rectangle(x, y, width, height), this.lines());
  }

  clip(): void {
    const name = `clip${++this.clips}`;
    this.add(`<clipPath id="${name}"><path d="${this.path}"/></clipPath>`);
    this.clipped = ` clip-path="url(#${name})"`;
  }

  measureText(text: string): TextMetrics {
    if (!this.measuring) throw new Error("The browser measures no text.");
    this.measuring.font = this.font;
    return this.measuring.measureText(text);
  }

  fillText(text: string, x: number, y: number): void {
    const size = Number.parseFloat(this.font);
    const { a, b, c, d, e, f } = this.matrix.translate(x, y).translate(0, BELOW[this.textBaseline] * size);
    const place =
      b === 0
        ? `x="${short(e)}" y="${short(f)}"`
        : `transform="matrix(${[a, b, c, d, e, f].map(short).join(" ")})"`;
    const words = text.replaceAll("&", "&amp;").replaceAll("<", "&lt;");
    const ink = paint("fill", this.fillStyle, this.globalAlpha);
    this.add(`<text ${place} text-anchor="${ANCHORS[this.textAlign]}" ${ink}${this.clipped}>${words}</text>`);
  }

  drawImage(
    image: HTMLCanvasElement,
    sx: number,
    sy: number,
    sw: number,
    sh: number,
    x: number,
    y: number,
    width: number,
    height: number,
  ): void {
    // biome-ignore format: as the canvas has it
    const part = document.createElement("canvas");
    [part.width, part.height] = [Math.ceil(width * FINER), Math.ceil(height * FINER)];
    const pen = part.getContext("2d");
    if (!pen) return;
    pen.imageSmoothingEnabled = false;
    pen.drawImage(image, sx, sy, sw, sh, 0, 0, part.width, part.height);
    const place = this.matrix.transformPoint({ x, y });
    this.add(
      `<image x="${short(place.x)}" y="${short(place.y)}" width="${short(width)}" height="${short(height)}" preserveAspectRatio="none" href="${part.toDataURL()}"${this.clipped}/>`,
    );
  }

  private lines(): string {
    const dashes = this.dashes && ` stroke-dasharray="${this.dashes}"`;
    const ends = `stroke-width="${this.lineWidth}" stroke-linejoin="${this.lineJoin}" stroke-linecap="${this.lineCap}"`;
    return `fill="none" ${paint("stroke", this.strokeStyle, this.globalAlpha)} ${ends}${dashes}`;
  }

  private draw(path: string, look: string): void {
    const attributes = look + this.clipped;
    if (attributes === this.last.attributes && !attributes.includes("opacity")) {
      this.last.path += path;
      return;
    }
    this.add("");
    this.last = { path, attributes };
  }

  /** Adds an element above the last path. */
  private add(element: string): void {
    const { path, attributes } = this.last;
    if (path !== "") this.elements.push(`<path d="${path}" ${attributes}/>`);
    this.last = { path: "", attributes: "" };
    if (element !== "") this.elements.push(element);
  }

  private place(x: number, y: number): string {
    const { a, b, c, d, e, f } = this.matrix;
    return `${short(a * x + c * y + e)} ${short(b * x + d * y + f)}`;
  }

  private rectangle(x: number, y: number, width: number, height: number): string {
    const corners = [[x, y], [x + width, y], [x + width, y + height], [x, y + height]] as const; // biome-ignore format: short
    return `M${corners.map(([cx, cy]) => this.place(cx, cy)).join("L")}Z`;
  }
}

/** A hundredth of a pixel is 3 µm of paper. */
const short = (value: number): string => String(Math.round(value * 100) / 100);

/** A colour as attributes; `rgb(1 2 3 / 0.5)` is younger than most programs that read SVG. */
function paint(what: "fill" | "stroke", colour: string, alpha: number): string {
  const parts = colour.startsWith("rgb") ? (colour.match(/[\d.]+/g) ?? []) : null;
  const opacity = alpha * Number(parts?.[3] ?? 1);
  const plain = parts ? `rgb(${parts.slice(0, 3).join(",")})` : colour;
  return `${what}="${plain}"${opacity < 1 ? ` ${what}-opacity="${short(opacity)}"` : ""}`;
}
