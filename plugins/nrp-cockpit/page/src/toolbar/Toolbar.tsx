import { useRun } from "../state/run";
import { Icon } from "../ui/Icon";
import { Clock } from "./Clock";
import { Pace } from "./Pace";
import { RecordButton } from "./RecordButton";
import { RunButtons } from "./RunButtons";
import { Seed } from "./Seed";
import { ShareButton } from "./ShareButton";
import { Viewers } from "./Viewers";
import "./toolbar.css";

/** The top line: which run this is, its controls, its times, its pace and its recording. */
export function Toolbar() {
  const experiment = useRun((run) => run.experiment);
  return (
    <header className="bar">
      {experiment && (
        <>
          <span className="bar-name cut" title={experiment.file}>
            {experiment.name}
          </span>
          <span className="chip" title="The brain's backend">
            <Icon name="brain" />
            {experiment.brain}
          </span>
          <span className="bar-times dim" aria-hidden="true">
            ×
          </span>
          <span className="chip" title="The world's backend">
            <Icon name="world" />
            {experiment.world}
          </span>
          <span className="bar-line" />
        </>
      )}
      <RunButtons />
      <Clock />
      <Pace />
      <span className="grow" />
      <Seed />
      <RecordButton />
      <ShareButton />
      <Viewers />
    </header>
  );
}
