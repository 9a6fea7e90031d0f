import { toggleRecording } from "../state/commands";
import { useBlocked, useRun } from "../state/run";
import { Button } from "../ui/Button";

const megabytes = (bytes: number) => `${(bytes / 1e6).toFixed(1)} MB`;

/** Starts or stops the recording; says how large it is. */
export function RecordButton() {
  const recording = useRun((run) => run.status?.recording ?? null);
  const source = useRun((run) => run.experiment?.source);
  const blocked = useBlocked();
  if (source === "recording") return null;
  return (
    <Button
      icon="record"
      className="bar-record"
      disabled={blocked}
      tip={recording ? `Stop recording to ${recording.path} (R)` : "Record from here (R)"}
      aria-label={recording ? "Stop recording" : "Record"}
      data-on={recording !== null}
      onClick={() => void toggleRecording()}
    >
      {recording ? "Recording" : "Record"}
      {recording && <span className="dim num wide">{megabytes(recording.bytes)}</span>}
    </Button>
  );
}
