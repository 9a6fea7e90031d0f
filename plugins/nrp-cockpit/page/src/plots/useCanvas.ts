import { type RefObject, useEffect, useRef } from "react";
import { useView } from "../state/view";
import { type Palette, readPalette } from "./palette";
import { useFrame } from "./useFrame";

/** What a painter draws with: sizes and places are in CSS pixels. */
export interface Sheet {
  pen: CanvasRenderingContext2D;
  width: number;
  height: number;
  /** Device pixels a CSS pixel. */
  ratio: number;
  colours: Palette;
}

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
  const redraw = useFrame(() => {
    colours.current ??= readPalette();
    if (ref.current) paintOn(ref.current, colours.current, paint);
  });
  // biome-ignore lint/correctness/useExhaustiveDependencies: the theme changes what the properties say
  useEffect(() => {
    colours.current = null;
    redraw();
  }, [dark, redraw]);
  useEffect(() => {
    const canvas = ref.current;
    if (!canvas) return;
    const observer = new ResizeObserver(redraw);
    observer.observe(canvas);
    return () => observer.disconnect();
  }, [redraw]);
  return { ref, redraw };
}

function paintOn(canvas: HTMLCanvasElement, colours: Palette, paint: (sheet: Sheet) => void): void {
  const { clientWidth: width, clientHeight: height } = canvas;
  const pen = canvas.getContext("2d");
  if (!pen || width === 0 || height === 0) return;
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
