import { takeSnapshot } from "../state/commands";
import { useBlocked, useMissing, useRecorded, useRun } from "../state/run";
import { IconButton } from "../ui/Button";
import { Icon } from "../ui/Icon";

interface TimelineHeadProps {
  zoomedIn: boolean;
  /** Whether there is a second run, and a lane for how it differs. */
  compared: boolean;
  onZoom: (factor: number) => void;
}

/** The names of the lanes, the verdict, and the buttons of the timeline. */
export function TimelineHead({ zoomedIn, compared, onZoom }: TimelineHeadProps) {
  const blocked = useBlocked();
  const missing = useMissing("snapshot");
  const live = !useRecorded();
  return (
    <div className="timeline-head">
      <div>
        <h2>Timeline</h2>
        <span className="grow" />
        <IconButton
          icon="minus"
          label="Zoom out"
          kind="ghost"
          small
          disabled={!zoomedIn && "The whole run is visible."}
          onClick={() => onZoom(2)}
        />
        <IconButton icon="plus" label="Zoom in" kind="ghost" small onClick={() => onZoom(0.5)} />
      </div>
      <div>Events</div>
      <div className="timeline-criteria-head">
        Criteria
        <span className="grow" />
        <Verdict />
      </div>
      <div>
        Snapshots
        <span className="grow" />
        {live && (
          <IconButton
            icon="snapshot"
            label="Take a snapshot"
            shortcut="S"
            kind="ghost"
            small
            disabled={blocked ?? missing}
            onClick={() => void takeSnapshot()}
          />
        )}
      </div>
      {compared && <div>Differences</div>}
    </div>
  );
}

/** Whether the run passed, as far as it is decided. */
function Verdict() {
  const verdict = useRun(({ status }) => {
    if (!status) return null;
    if (status.passed !== null) return status.passed ? "passed" : "failed";
    const over = status.state === "finished" || status.state === "failed";
    return over && !status.complete ? "not complete" : null;
  });
  if (verdict === null) return null;
  const kind = verdict === "passed" ? "ok" : verdict === "failed" ? "bad" : "warn";
  return (
    <span className={`tag tag-${kind}`} role="status">
      <Icon name={kind === "ok" ? "check" : kind === "bad" ? "error" : "warning"} small />
      {verdict}
    </span>
  );
}
