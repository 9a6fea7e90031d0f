import { pause, play, type ResetWhat, reset, step, stepBack } from "../state/commands";
import { useBlocked, useMissing, useRecorded, useRun } from "../state/run";
import { IconButton } from "../ui/Button";
import { Icon, type IconName } from "../ui/Icon";
import { Menu } from "../ui/Menu";

const RESETS: { what: ResetWhat; label: string; icon: IconName }[] = [
  { what: "all", label: "Reset everything", icon: "reset" },
  { what: "robot", label: "Reset the robot", icon: "target" },
  { what: "brain", label: "Reset the brain", icon: "brain" },
  { what: "world", label: "Reset the world", icon: "world" },
];

/** Step back, play or pause, step, reset. */
export function RunButtons() {
  const running = useRun((run) => run.status?.state === "running");
  const over = useRun((run) => run.status?.state === "finished" || run.status?.state === "failed");
  const blocked = useBlocked();
  const noWayBack = useMissing("step_back");
  const ended = over ? "The run has ended: step back or reset." : undefined;
  const resets = useRecorded() ? RESETS.slice(0, 1) : RESETS; // of a recording only its time goes back
  const items = resets.map(({ what, ...item }) => ({ ...item, onSelect: () => void reset(what) }));
  return (
    // biome-ignore lint/a11y/useSemanticElements: a fieldset has no place in a toolbar
    <div className="btn-group" role="group" aria-label="Run">
      <IconButton
        icon="stepBack"
        label="Step back"
        shortcut=","
        disabled={blocked ?? noWayBack}
        onClick={() => void stepBack()}
      />
      <IconButton
        icon={running ? "pause" : "play"}
        label={running ? "Pause" : "Play"}
        shortcut="Space"
        kind={blocked || ended ? "plain" : "primary"}
        className="bar-play"
        disabled={blocked ?? ended}
        onClick={() => void (running ? pause() : play())}
      />
      <IconButton
        icon="step"
        label="Step"
        shortcut="."
        disabled={blocked ?? ended}
        onClick={() => void step()}
      />
      <Menu label="Reset" items={items} className="btn bar-reset" disabled={blocked} data-key="reset">
        <Icon name="reset" />
        <Icon name="down" small />
      </Menu>
    </div>
  );
}
