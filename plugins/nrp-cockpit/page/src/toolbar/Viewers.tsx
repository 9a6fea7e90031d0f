import { useRun } from "../state/run";
import { Icon } from "../ui/Icon";

/** How many pages look at this run. */
export function Viewers() {
  const viewers = useRun((run) => run.status?.viewers ?? 0);
  const maySteer = useRun((run) => run.experiment?.may_steer ?? false);
  if (viewers < 1) return null;
  const words = `${viewers} ${viewers === 1 ? "viewer" : "viewers"}; you ${maySteer ? "can control the run" : "can only watch"}`;
  return (
    <span className="row tight f12 mut wide" title={words}>
      <Icon name="viewers" />
      <span aria-hidden="true">{viewers}</span>
      <span className="hidden-text">{words}</span>
    </span>
  );
}
