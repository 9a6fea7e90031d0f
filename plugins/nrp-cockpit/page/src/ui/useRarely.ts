import { useEffect, useMemo, useRef } from "react";
import { Rarely } from "./rarely";

/** Makes a call at most so often when asked, and a last one after the last ask. */
export function useRarely(every_ms: number, call: () => void): Rarely {
  const latest = useRef(call);
  useEffect(() => {
    latest.current = call;
  });
  const rarely = useMemo(() => new Rarely(() => latest.current(), every_ms), [every_ms]);
  useEffect(() => () => rarely.stop(), [rarely]);
  return rarely;
}
