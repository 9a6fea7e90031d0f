import { useRun } from "../state/run";
import { Icon } from "../ui/Icon";
import { isPlayed } from "../wire/recording";

/** How many pages look at this run, and whether this and others can control it. */
export function Viewers() {
  const viewers = useRun((run) => run.status?.viewers ?? 0);
  const controllers = useRun((run) => run.status?.controllers ?? 0);
  const maySteer = useRun((run) => run.experiment?.may_steer ?? false);
  if (viewers < 1 || isPlayed()) return null;
  const who = maySteer ? "you can control the run" : "you can only watch";
  const words = `${viewers} ${viewers === 1 ? "viewer" : "viewers"}, ${controllers} in control; ${who}`;
  return (
    <span className="row tight f12 mut wide" title={words}>
      <Icon name="viewers" />
      <span aria-hidden="true">{viewers}</span>
      {!maySteer && <b aria-hidden="true">Watching only</b>}
      {maySteer && controllers > 1 && <b aria-hidden="true">{controllers} in control</b>}
      <span className="hidden-text">{words}</span>
    </span>
  );
}
