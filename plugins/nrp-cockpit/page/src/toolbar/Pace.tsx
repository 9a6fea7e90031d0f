import { setPace } from "../state/commands";
import { useBlocked, useRun } from "../state/run";

/** The paces of the slider; the last is as fast as the machine can. */
const PACES = [0.1, 0.25, 0.5, 1, 2, 5, 10, null];

const nearest = (pace: number | null): number =>
  pace === null
    ? PACES.length - 1
    : PACES.reduce<number>(
        (best, one, at) =>
          one !== null && Math.abs(Math.log(one / pace)) < Math.abs(Math.log((PACES[best] ?? 1e9) / pace))
            ? at
            : best,
        0,
      );

/** How many simulated seconds a wall second may hold. */
export function Pace() {
  const said = useRun((run) => run.status?.pace);
  const pace = said ?? null;
  const blocked = useBlocked();
  const at = nearest(pace);
  const shown = said === undefined ? "–" : pace === null ? "max" : `${pace}×`;
  return (
    <label className="bar-pace row tight f12 mut">
      Pace
      <input
        type="range"
        min={0}
        max={PACES.length - 1}
        step={1}
        value={at}
        disabled={blocked !== undefined}
        aria-valuetext={pace === null ? "as fast as possible" : `${pace} times real time`}
        style={{ "--v": `${(at / (PACES.length - 1)) * 100}%` } as React.CSSProperties}
        onChange={(event) => void setPace(PACES[Number(event.target.value)] ?? null)}
      />
      <span className="bar-pace-value num">{shown}</span>
    </label>
  );
}
