import { useEffect, useState } from "react";
import { wire } from "../wire";

/**
 * Asks a service again and again while the component is mounted: what nobody looks at is not read. Null until the first
 * answer; a text is the reason why there is none.
 */
export function useLook<T>(service: string, request: object, every_ms: number): T | string | null {
  const [seen, setSeen] = useState<T | string | null>(null);
  const key = JSON.stringify(request);
  useEffect(() => {
    let timer = 0;
    let open = true;
    const look = async () => {
      const answer = await wire
        .call<T>(`/cockpit/${service}`, JSON.parse(key))
        .catch((error: Error) => error.message);
      if (!open) return;
      setSeen(answer);
      if (typeof answer !== "string") timer = window.setTimeout(look, every_ms);
    };
    void look();
    return () => {
      open = false;
      window.clearTimeout(timer);
    };
  }, [service, key, every_ms]);
  return seen;
}
