import { useEffect, useState } from "react";
import type { CellGroup } from "../state/types";
import { wire } from "../wire";
import { type ConnectionData, Connections } from "./connections";

/** What was asked, by the groups of the run: several views show it. */
const asked = new WeakMap<readonly CellGroup[], Promise<Connections | null>>();

/** Asks once for the synapses between groups, if there are any; null before, and where the run cannot tell. */
export function useConnections(groups: readonly CellGroup[]): Connections | null {
  const [found, setFound] = useState<Connections | null>(null);
  useEffect(() => {
    let open = true;
    setFound(null);
    void connectionsOf(groups).then((one) => open && setFound(one));
    return () => {
      open = false;
    };
  }, [groups]);
  return found;
}

function connectionsOf(groups: readonly CellGroup[]): Promise<Connections | null> {
  const known = asked.get(groups);
  if (known) return known;
  const hasParts = groups.some(({ own }) => Object.keys(own).length > 0);
  const answer = hasParts ? ask() : Promise.resolve(null);
  asked.set(groups, answer);
  return answer;
}

const ask = (): Promise<Connections | null> =>
  wire.call<ConnectionData>("/cockpit/connections", {}).then(
    (data) => new Connections(data),
    () => null, // a recording does not know them
  );
