import { useEffect, useRef, useState } from "react";
import { usePanelChoice } from "../state/panelChoices";
import { useRun } from "../state/run";
import { Empty, Panel } from "../ui/Panel";
import { Axes } from "./Axes";
import type { Mode } from "./choices";
import { Labels } from "./Labels";
import { SceneTools } from "./SceneTools";
import { type Steering, steer } from "./steering";
import { useMode } from "./useMode";
import { useLayers } from "./useSights";
import { useViewer } from "./useViewer";
import { Viewer } from "./viewer";
import "./scene.css";

type Pushed = Parameters<Steering["onPush"]>[0];

/** The world in three dimensions. */
export default function ScenePanel() {
  const [mode, setMode] = usePanelChoice<Mode>("orbit");
  const canvas = useRef<HTMLCanvasElement>(null);
  const made = useViewer(canvas);
  const viewer = made instanceof Viewer ? made : null;
  const experiment = useRun((run) => run.experiment);
  useMode(viewer, mode, experiment?.robots[0]);
  useLayers(viewer);
  const pushed = useSteering(canvas, viewer, mode);
  return (
    <Panel
      title="Scene"
      sub={experiment && `${experiment.world} · ${experiment.bodies.length} models`}
      className="scene"
      tools={<SceneTools mode={mode} onMode={setMode} onFit={() => viewer?.fit()} />}
    >
      {/* biome-ignore lint/a11y/noInteractiveElementToNoninteractiveRole: it acts on keys of its own */}
      <canvas
        ref={canvas}
        className="panel-canvas"
        tabIndex={0}
        role="application"
        aria-label="The scene in three dimensions: arrows orbit, Shift and arrows pan, plus and minus zoom"
      />
      {typeof made === "string" && <Empty>{made}</Empty>}
      {viewer && <Labels viewer={viewer} />}
      {viewer && <Axes viewer={viewer} />}
      {pushed && (
        <div className="scene-push num" style={{ left: pushed.x, top: pushed.y }}>
          {pushed.text}
        </div>
      )}
      <p className="scene-hint tall" aria-hidden="true">
        drag to orbit · <kbd>Shift</kbd> drag to pan · <kbd>Alt</kbd> drag a body to push it
      </p>
    </Panel>
  );
}

/** Steers the view while it is there; returns the push that is being dragged. */
function useSteering(
  canvas: { current: HTMLCanvasElement | null },
  viewer: Viewer | null,
  mode: Mode,
): Pushed {
  const [pushed, setPushed] = useState<Pushed>(null);
  useEffect(() => {
    if (!canvas.current || !viewer) return;
    return steer(canvas.current, { viewer, turns: () => mode !== "above", onPush: setPushed });
  }, [canvas, viewer, mode]);
  return pushed;
}
