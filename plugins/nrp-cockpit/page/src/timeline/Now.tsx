import { useRun } from "../state/run";
import { percent, type Span } from "./scale";

/** The current time: what is past is tinted, and the line carries the number. */
export function Now({ span }: { span: Span }) {
  const t_s = useRun((run) => run.status?.t_s ?? 0);
  const at = percent(span, t_s);
  if (at < 0 || at > 100) return null;
  const edge = at > 95 ? "right" : at < 3 ? "left" : undefined;
  return (
    <>
      <div className="timeline-past" style={{ width: `${at}%` }} />
      <div className="timeline-now" style={{ left: `${at}%` }}>
        <span className="num" data-edge={edge}>
          {t_s.toFixed(2)}
        </span>
      </div>
    </>
  );
}
