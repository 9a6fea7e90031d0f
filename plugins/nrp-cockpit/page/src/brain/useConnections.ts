import { useEffect, useState } from "react";
import type { CellGroup } from "../state/types";
import { wire } from "../wire";
import { type ConnectionData, Connections } from "./connections";

/** Asks once for the synapses between groups, if there are any; null before, and where the run cannot tell. */
export function useConnections(groups: readonly CellGroup[]): Connections | null {
  const [found, setFound] = useState<Connections | null>(null);
  useEffect(() => {
    setFound(null);
    if (groups.every(({ own }) => Object.keys(own).length === 0)) return;
    let open = true;
    const answer = wire.call<ConnectionData>("/cockpit/connections", {});
    answer.then(
      (data) => open && setFound(new Connections(data)),
      () => undefined, // a recording does not know them
    );
    return () => {
      open = false;
    };
  }, [groups]);
  return found;
}
