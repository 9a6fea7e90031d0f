import type { Comparison } from "../difference/comparison";
import { distanceOf } from "../difference/words";
import { drawEvents, drawTimeAxis, MARGIN, setFont } from "../plots/pen";
import { xOf } from "../plots/timeAxis";
import { paintValues, TOP } from "../plots/tracesPicture";
import { type Sheet, useCanvas } from "../plots/useCanvas";

/** The distance between the robots of the two runs over time. */
export function DistancePlot({ comparison }: { comparison: Comparison }) {
  const { ref } = useCanvas((sheet) => paintDistance(sheet, comparison));
  const { from_s, to_s, most_m } = extentOf(comparison);
  return (
    <figure className="distance">
      <figcaption className="mut f11">
        Distance between the robots (m)
        <span className="grow" />
        <span className="num">at most {distanceOf(most_m)}</span>
      </figcaption>
      <canvas
        ref={ref}
        role="img"
        data-y="Distance (m)"
        aria-label={`Distance between the robots from ${from_s.toFixed(2)} s to ${to_s.toFixed(2)} s, at most ${distanceOf(most_m)}`}
      />
    </figure>
  );
}

function extentOf({ distances }: Comparison) {
  const from_s = distances[0]?.[0] ?? 0;
  const to_s = Math.max(distances.at(-1)?.[0] ?? 0, from_s + 1);
  return { from_s, to_s, most_m: Math.max(...distances.map(([, distance_m]) => distance_m), 0) };
}

function paintDistance(sheet: Sheet, comparison: Comparison): void {
  const { pen, colours, width, height } = sheet;
  const { from_s, to_s, most_m } = extentOf(comparison);
  const scale = { from_s, to_s, left: MARGIN.left, right: width - MARGIN.right };
  const [bottom, high] = [height - MARGIN.bottom, most_m || 1];
  const yOf = (distance_m: number) => bottom - (distance_m / high) * (bottom - TOP);
  setFont(sheet);
  drawTimeAxis(sheet, scale, TOP, bottom);
  paintValues(sheet, scale, [0, high], yOf, bottom);
  const first = comparison.first.map(({ what, t_s }) => ({ name: what, t_s }));
  drawEvents(sheet, scale, first, { top: TOP, bottom });
  pen.strokeStyle = colours.text2;
  pen.lineWidth = 1.5;
  pen.beginPath();
  for (const [t_s, distance_m] of comparison.distances) pen.lineTo(xOf(scale, t_s), yOf(distance_m));
  pen.stroke();
}
