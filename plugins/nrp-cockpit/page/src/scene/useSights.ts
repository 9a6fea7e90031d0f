import { useEffect } from "react";
import { useRun } from "../state/run";
import type { Mount } from "../state/types";
import { wire } from "../wire";
import { type Layer, useChoices } from "./choices";
import type { LaserScan } from "./sightLines";
import { CONTACTS, type Contacts } from "./touches";
import type { Viewer } from "./viewer";

const NO_MOUNTS: readonly Mount[] = [];

export const useMounts = (): readonly Mount[] => useRun((run) => run.experiment?.mounts ?? NO_MOUNTS);

/** Shows the lights, and the layers that the person chose; scans and contacts are heard only while they are shown. */
export function useLayers(viewer: Viewer | null): void {
  const mounts = useMounts();
  const layers = useChoices((choices) => choices.layers);
  const rays = layers.has("rays");
  useEffect(() => viewer?.mount(mounts), [viewer, mounts]);
  // biome-ignore lint/correctness/useExhaustiveDependencies: newly mounted sensors are shown by the same layers
  useEffect(() => viewer?.showLayers(layers), [viewer, layers, mounts]);
  useEffect(() => {
    if (!viewer || !rays) return;
    const stops = mounts
      .filter(({ view }) => view === null)
      .map((mount) => wire.subscribe<LaserScan>(mount.topic, (scan) => viewer.scan(mount, scan), "latest"));
    return () => {
      for (const stop of stops) stop();
    };
  }, [viewer, mounts, rays]);
  const contacts = layers.has("contacts");
  useEffect(() => {
    if (!viewer || !contacts) return;
    return wire.subscribe<Contacts>(CONTACTS, (found) => viewer.touch(found), "latest");
  }, [viewer, contacts]);
  const lights = useRun((run) => run.experiment?.lights);
  useEffect(() => {
    if (lights) viewer?.light(lights);
  }, [viewer, lights]);
}

/** The layers that this run has anything for. */
export function useOfferedLayers(): ReadonlySet<Layer> {
  const mounts = useMounts();
  const offered = mounts.map(({ view }): Layer => (view ? "frustum" : "rays"));
  const touches = useRun((run) => run.experiment?.topics.some(({ name }) => name === CONTACTS));
  return new Set<Layer>(["trail", ...offered, ...(touches ? (["contacts"] as const) : [])]);
}
