import { forget } from "../state/commands";
import type { TimelineData } from "../state/types";
import { Icon } from "../ui/Icon";
import { Tooltip } from "../ui/Tooltip";
import { go } from "./go";
import { here } from "./here";
import { restoring } from "./reach";
import { percent, type Span } from "./scale";

/** Snapshots and ends of abandoned futures as chips; a click restores. Automatic ones are ticks. */
export function SnapshotLane({ data, span }: { data: TimelineData; span: Span }) {
  const { snapshots, automatic_s } = data;
  return (
    <ul className="timeline-lane" aria-label="Snapshots">
      {automatic_s.map((t_s) => (
        <li
          key={t_s}
          className="timeline-automatic"
          style={{ left: `${percent(span, t_s)}%` }}
          aria-hidden="true"
        />
      ))}
      {snapshots.map((snapshot) => (
        <li key={snapshot.id} className="timeline-mark" style={{ left: `${percent(span, snapshot.t_s)}%` }}>
          <Tooltip text={`${restoring(snapshot).says}. Press Delete or Shift-click to remove it.`}>
            <button
              type="button"
              className="chip num"
              aria-label={restoring(snapshot).says}
              aria-keyshortcuts="Delete"
              onKeyDown={(event) => event.key === "Delete" && void forget(snapshot.id)}
              onClick={(event) => {
                if (event.shiftKey) {
                  void forget(snapshot.id);
                  return;
                }
                const { blocked } = here();
                void go(blocked ? { act: "none", t_s: snapshot.t_s, says: blocked } : restoring(snapshot));
              }}
            >
              <Icon name={snapshot.left ? "branch" : "snapshot"} small />
              {snapshot.t_s.toFixed(2)}
            </button>
          </Tooltip>
        </li>
      ))}
    </ul>
  );
}
