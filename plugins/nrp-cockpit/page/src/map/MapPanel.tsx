import { useCallback, useEffect, useRef, useState } from "react";
import { useCanvas } from "../plots/useCanvas";
import { useRun } from "../state/run";
import { useSelection } from "../state/selection";
import { IconButton } from "../ui/Button";
import { Empty, Panel } from "../ui/Panel";
import type { Pose } from "../world/pose";
import { world } from "../world/world";
import type { Footprint } from "./footprint";
import { paintMap } from "./paintMap";
import { Plan } from "./plan";
import { fittedTo, type MapView } from "./projection";
import { steerMap } from "./steerMap";
import "./map.css";

const poseOf = (frame: string): Pose => world.frame(frame);

/** The room from above, with the robots' paths. */
export function MapPanel() {
  const map = useMap();
  return (
    <Panel
      title="From above"
      className="map"
      tools={<IconButton icon="fit" label="Fit the map" kind="ghost" small onClick={map.fit} />}
    >
      {/* biome-ignore lint/a11y/noInteractiveElementToNoninteractiveRole: it acts on keys of its own */}
      <canvas
        ref={map.ref}
        className="panel-canvas"
        tabIndex={0}
        role="application"
        aria-label="The room from above: arrows move it, plus and minus zoom"
      />
      {map.empty && <Empty>Waiting for the scene.</Empty>}
    </Panel>
  );
}

function useMap() {
  const plan = useRef(new Plan());
  /** What the person chose to see; null: all of the room. */
  const chosen = useRef<MapView | null>(null);
  const view = useRef<MapView | null>(null);
  const seen = useRef<readonly Footprint[]>([]);
  const [empty, setEmpty] = useState(true);
  const selected = useSelection(({ selected: one }) => (one?.kind === "body" ? one.name : null));
  const { ref, redraw } = useCanvas((sheet) => {
    const moving = world.awaited ? [] : plan.current.moving(poseOf);
    const { still } = plan.current;
    seen.current = [...still, ...moving];
    const wider = sheet.width / (ref.current?.clientWidth || sheet.width); // a figure has a width of its own
    view.current = chosen.current
      ? { ...chosen.current, scale: chosen.current.scale * wider }
      : fittedTo(still.length > 0 ? still : moving, sheet);
    if (view.current) paintMap(sheet, { view: view.current, still, moving, selected, robots: robotsOfNow() });
  });
  useEffect(() => {
    const scene = () => {
      plan.current.read(world.entities, poseOf);
      setEmpty(world.entities.size === 0);
      redraw();
    };
    scene();
    return world.follow((change) => (change === "scene" ? scene() : redraw()));
  }, [redraw]);
  const show = useCallback(
    (next: MapView | null) => {
      chosen.current = next;
      redraw();
    },
    [redraw],
  );
  useEffect(() => {
    if (!ref.current) return;
    return steerMap(ref.current, {
      view: () => chosen.current ?? view.current,
      setView: show,
      footprints: () => seen.current,
    });
  }, [ref, show]);
  return { ref, empty, fit: () => show(null) };
}

const robotsOfNow = () =>
  (useRun.getState().experiment?.robots ?? []).flatMap((name) => {
    const pose = world.models.get(name);
    return pose ? { name, pose, trail: world.trails.get(name) } : [];
  });
