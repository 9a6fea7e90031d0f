import { useMissing, useRun } from "../state/run";

/** Why the functions can be read only, or undefined when they can be edited. */
export function useReadOnly(): string | undefined {
  const maySteer = useRun((run) => run.experiment?.may_steer ?? false);
  const recording = useRun((run) => run.experiment?.source === "recording");
  const missing = useMissing("functions");
  if (recording) return "This is a recording: the functions are as they ran.";
  if (!maySteer) return "You may watch this run, not steer it.";
  return missing;
}
