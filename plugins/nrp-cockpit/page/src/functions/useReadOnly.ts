import { useMissing, useRecorded, useRun } from "../state/run";

/** Why the functions can be read only, or undefined when they can be edited. */
export function useReadOnly(): string | undefined {
  const maySteer = useRun((run) => run.experiment?.may_steer ?? false);
  const recording = useRecorded();
  const missing = useMissing("functions");
  if (recording) return "This is a recording: its functions cannot be changed.";
  if (!maySteer) return "You can watch this run, but not control it.";
  return missing;
}
