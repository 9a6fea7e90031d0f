import { useEffect } from "react";
import type { Vector } from "../state/types";
import { world } from "../world/world";
import type { Mode } from "./choices";
import { fromAbove, type Orbit } from "./orbit";
import type { Viewer } from "./viewer";

const FOLLOWED_FROM_M = 4;

const aimed = (view: Orbit, target: Readonly<Vector>): Orbit => ({ ...view, target });

/** Keeps the view as the mode says: free, after the robot, or from above. */
export function useMode(viewer: Viewer | null, mode: Mode, robot: string | undefined): void {
  useEffect(() => {
    if (!viewer || mode === "orbit") return;
    const before = viewer.view;
    if (mode === "follow") return robot === undefined ? undefined : follow(viewer, robot);
    viewer.view = fromAbove(before);
    return () => {
      viewer.view = { ...viewer.view, azimuth: before.azimuth, elevation: before.elevation };
    };
  }, [viewer, mode, robot]);
}

function follow(viewer: Viewer, robot: string): () => void {
  let last = world.models.get(robot)?.position;
  if (last)
    viewer.view = {
      ...aimed(viewer.view, last),
      distance_m: Math.min(viewer.view.distance_m, FOLLOWED_FROM_M),
    };
  return world.follow(() => {
    const now = world.models.get(robot)?.position;
    if (!now) return;
    const { target } = viewer.view;
    const moved = (axis: 0 | 1 | 2) => target[axis] + now[axis] - (last ?? target)[axis];
    viewer.view = aimed(viewer.view, [moved(0), moved(1), moved(2)]);
    last = now;
  });
}
