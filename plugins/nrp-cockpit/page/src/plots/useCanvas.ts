import { type RefObject, useEffect, useRef } from "react";
import { useView } from "../state/view";
import { type Palette, readPalette } from "./palette";
import { useFrame } from "./useFrame";

type Lines =
  | "beginPath"
  | "closePath"
  | "moveTo"
  | "lineTo"
  | "rect"
  | "setLineDash"
  | "fillRect"
  | "strokeRect";
type Words = "font" | "textAlign" | "textBaseline" | "measureText";
type Looks = "strokeStyle" | "fillStyle" | "lineWidth" | "lineJoin" | "lineCap" | "globalAlpha";
type States = "save" | "restore" | "translate" | "rotate" | "imageSmoothingEnabled";

/** What painters use of the pen of a canvas. */
export interface Pen extends Pick<CanvasRenderingContext2D, Lines | Words | Looks | States> {
  fill(): void;
  stroke(): void;
  clip(): void;
  fillText(text: string, x: number, y: number): void;
  drawImage(image: HTMLCanvasElement, sx: number, sy: number, sw: number, sh: number, x: number, y: number, width: number, height: number): void; // biome-ignore format: as the canvas has it
}

/** What a painter draws with: sizes and places are in CSS pixels. */
export interface Sheet {
  pen: Pen;
  width: number;
  height: number;
  /** Device pixels a CSS pixel. */
  ratio: number;
  colours: Palette;
  /** Whether it is a figure for print: lines and words instead of pixels, without cursors. */
  figure?: boolean;
}

interface Painter {
  paint: (sheet: Sheet) => void;
  redraw: () => void;
}

const painters = new WeakMap<HTMLCanvasElement, Painter>();

/** What paints a canvas; after another sheet it must redraw its own. */
export const painterOf = (canvas: HTMLCanvasElement): Painter | undefined => painters.get(canvas);

/** As it was last observed: to ask the element in each frame would lay out the page in each. */
interface Size {
  readonly width: number;
  readonly height: number;
}

const NO_SIZE: Size = { width: 0, height: 0 };

interface Canvas {
  ref: RefObject<HTMLCanvasElement | null>;
  /** Asks for a new picture in the next frame. */
  redraw: () => void;
}

/** A canvas as large as its element, painted at most once a frame, when asked and when size or theme change. */
export function useCanvas(paint: (sheet: Sheet) => void): Canvas {
  const ref = useRef<HTMLCanvasElement>(null);
  const colours = useRef<Palette | null>(null);
  const dark = useView((view) => view.dark);
  const size = useRef<Size>(NO_SIZE);
  const redraw = useFrame(() => {
    if (!ref.current || size.current.width === 0 || size.current.height === 0) return;
    colours.current ??= readPalette();
    paintOn(ref.current, size.current, colours.current, paint);
  });
  useEffect(() => {
    if (ref.current) painters.set(ref.current, { paint, redraw });
  });
  // biome-ignore lint/correctness/useExhaustiveDependencies: the theme changes what the properties say
  useEffect(() => {
    colours.current = null;
    redraw();
  }, [dark, redraw]);
  useEffect(() => {
    const canvas = ref.current;
    if (!canvas) return;
    const observer = new ResizeObserver(([entry]) => {
      if (entry) {
        const { width, height } = entry.contentRect;
        size.current = { width: Math.round(width), height: Math.round(height) };
      }
      redraw();
    });
    observer.observe(canvas);
    return () => observer.disconnect();
  }, [redraw]);
  return { ref, redraw };
}

function paintOn(
  canvas: HTMLCanvasElement,
  { width, height }: Size,
  colours: Palette,
  paint: (sheet: Sheet) => void,
): void {
  const pen = canvas.getContext("2d");
  if (!pen) return;
  const ratio = window.devicePixelRatio;
  const [wide, high] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== wide || canvas.height !== high) {
    canvas.width = wide;
    canvas.height = high;
  }
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  paint({ pen, width, height, ratio, colours });
}
