import type { Comparison } from "../difference/comparison";
import { distanceOf } from "../difference/words";

const WIDTH = 600;
const HEIGHT = 100;

/** The distance between the robots of the two runs over time. */
export function DistancePlot({ comparison: { distances, first } }: { comparison: Comparison }) {
  const from_s = distances[0]?.[0] ?? 0;
  const to_s = Math.max(distances.at(-1)?.[0] ?? 0, from_s + 1);
  const most_m = Math.max(...distances.map(([, distance_m]) => distance_m), 0);
  const x = (t_s: number) => ((t_s - from_s) / (to_s - from_s)) * WIDTH;
  const y = (distance_m: number) => HEIGHT - (most_m > 0 ? distance_m / most_m : 0) * HEIGHT;
  const points = distances.map(([t_s, distance_m]) => `${x(t_s).toFixed(1)},${y(distance_m).toFixed(1)}`);
  return (
    <figure className="distance">
      <figcaption className="mut f11">
        Distance between the robots
        <span className="grow" />
        <span className="num">at most {distanceOf(most_m)}</span>
      </figcaption>
      <svg
        viewBox={`0 0 ${WIDTH} ${HEIGHT}`}
        preserveAspectRatio="none"
        role="img"
        aria-label={`Distance between the robots from ${from_s.toFixed(2)} s to ${to_s.toFixed(2)} s, at most ${distanceOf(most_m)}`}
      >
        {first.map(({ what, t_s }) => (
          <line key={what} className={`first-${what}`} x1={x(t_s)} x2={x(t_s)} y1={0} y2={HEIGHT} />
        ))}
        <polyline points={points.join(" ")} />
      </svg>
      <p className="mut f11 num distance-axis" aria-hidden="true">
        <span>{from_s.toFixed(2)} s</span>
        <span>{to_s.toFixed(2)} s</span>
      </p>
    </figure>
  );
}
