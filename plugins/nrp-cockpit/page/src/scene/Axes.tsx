import { useEffect, useRef } from "react";
import { axesInImage, type Orbit } from "./orbit";
import type { Viewer } from "./viewer";

const NAMES = ["x", "y", "z"] as const;
const LENGTH = 18;

/** The directions of the axes in the image. */
export function Axes({ viewer }: { viewer: Viewer }) {
  const drawing = useRef<SVGSVGElement>(null);
  useEffect(() => {
    let shown: Orbit | null = null;
    return viewer.onDrawn(() => {
      if (viewer.view === shown) return; // bodies move, the view seldom does
      shown = viewer.view;
      axesInImage(shown).forEach(([right, up], at) => {
        const axis = drawing.current?.children[at];
        const [x, y] = [right * LENGTH, -up * LENGTH];
        axis?.querySelector("line")?.setAttribute("x2", String(x));
        axis?.querySelector("line")?.setAttribute("y2", String(y));
        axis?.querySelector("text")?.setAttribute("transform", `translate(${x * 1.35} ${y * 1.35})`);
      });
    });
  }, [viewer]);
  return (
    <svg ref={drawing} className="scene-axes" viewBox="-28 -28 56 56" aria-hidden="true">
      {NAMES.map((name) => (
        <g key={name} data-axis={name}>
          <line />
          <text>{name}</text>
        </g>
      ))}
    </svg>
  );
}
