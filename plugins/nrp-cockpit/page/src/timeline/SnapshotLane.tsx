import { forget } from "../state/commands";
import type { TimelineData } from "../state/types";
import { Icon } from "../ui/Icon";
import { Tooltip } from "../ui/Tooltip";
import { go } from "./go";
import { here } from "./here";
import { restoring } from "./reach";
import { percent, type Span } from "./scale";

/** Snapshots as chips; a click restores. */
export function SnapshotLane({ snapshots, span }: { snapshots: TimelineData["snapshots"]; span: Span }) {
  return (
    <ul className="timeline-lane" aria-label="Snapshots">
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
              <Icon name="snapshot" small />
              {snapshot.t_s.toFixed(2)}
            </button>
          </Tooltip>
        </li>
      ))}
    </ul>
  );
}
