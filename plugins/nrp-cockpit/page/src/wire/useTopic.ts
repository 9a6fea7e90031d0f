import { useEffect, useRef } from "react";
import type { Handler } from "./subscriptions";
import { wire } from "./wire";

/**
 * Hears a topic while the component is mounted, so nothing is sent for a room that is closed. `null`: hear nothing.
 * The handler may change from render to render; drawing code should keep its data in a ref, not in state.
 */
export function useTopic<T>(
  topic: string | null,
  handler: Handler<T>,
  kind: "every" | "latest" = "every",
): void {
  const current = useRef(handler);
  useEffect(() => {
    current.current = handler;
  });
  useEffect(() => {
    if (topic === null) return;
    return wire.subscribe<T>(topic, (message, t_s) => current.current(message, t_s), kind);
  }, [topic, kind]);
}
