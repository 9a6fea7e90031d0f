import { useRecorded, useRun } from "../state/run";

/** Simulated time over wall time, and how fast the one runs beside the other. */
export function Clock() {
  const status = useRun((run) => run.status);
  const duration = useRun((run) => run.experiment?.duration_s ?? null);
  const recorded = useRecorded();
  if (!status) return null;
  const factor = status.real_time_factor;
  return (
    <>
      <div className="bar-clock num" role="timer" aria-label="Simulated and wall time">
        <p className="bar-value">
          {status.t_s.toFixed(2)} s {duration !== null && <span className="dim">of {duration} s</span>}
        </p>
        <p className="dim f11">wall {status.wall_s.toFixed(1)} s</p>
      </div>
      {!recorded && (
        <div className="bar-factor num">
          <p className="bar-value">{factor === null ? "–" : `${factor.toFixed(2)}×`}</p>
          <p className="dim f11">real time</p>
        </div>
      )}
    </>
  );
}
