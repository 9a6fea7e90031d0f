import { useEffect, useRef, useState } from "react";
import { usePanelChoice } from "../state/panelChoices";
import { useMissing, useRun } from "../state/run";
import { counted } from "../ui/counts";
import { Empty, Panel } from "../ui/Panel";
import { Axes } from "./Axes";
import type { Mode } from "./choices";
import { EditBar } from "./EditBar";
import { Labels } from "./Labels";
import { SceneTools } from "./SceneTools";
import { type Steering, steer } from "./steering";
import { useMode } from "./useMode";
import { useLayers } from "./useSights";
import { useViewer } from "./useViewer";
import { Viewer } from "./viewer";
import "./scene.css";

type Dragged = Parameters<Steering["onDrag"]>[0];

/** The world in three dimensions. */
export default function ScenePanel() {
  const [mode, setMode] = usePanelChoice<Mode>("orbit");
  const canvas = useRef<HTMLCanvasElement>(null);
  const made = useViewer(canvas);
  const viewer = made instanceof Viewer ? made : null;
  const experiment = useRun((run) => run.experiment);
  const pushes = useMissing("push") === undefined;
  useMode(viewer, mode, experiment?.robots[0]);
  useLayers(viewer);
  const dragged = useSteering(canvas, viewer, mode);
  return (
    <Panel
      title="Scene"
      sub={experiment && counted(experiment.bodies.length, "model")}
      className="scene"
      tools={<SceneTools mode={mode} onMode={setMode} onFit={() => viewer?.fit()} />}
    >
      {/* biome-ignore lint/a11y/noInteractiveElementToNoninteractiveRole: it acts on keys of its own */}
      <canvas
        ref={canvas}
        className="panel-canvas"
        tabIndex={0}
        role="application"
        aria-label="The scene in three dimensions: arrows orbit, Shift and arrows pan, plus and minus zoom; while bodies are edited, arrows move the selected one"
      />
      {typeof made === "string" && <Empty>{made}</Empty>}
      {viewer && <Labels viewer={viewer} />}
      {viewer && <Axes viewer={viewer} />}
      {dragged && (
        <div className="scene-drag num" style={{ left: dragged.x, top: dragged.y }}>
          {dragged.text}
        </div>
      )}
      <EditBar canvas={canvas} />
      <p className="scene-hint tall" aria-hidden="true">
        drag to orbit · <kbd>Shift</kbd> drag to pan
        {pushes && (
          <>
            {" "}
            · <kbd>Alt</kbd> drag a body to push it
          </>
        )}
      </p>
    </Panel>
  );
}

/** Steers the view while it is there; returns what is being dragged. */
function useSteering(
  canvas: { current: HTMLCanvasElement | null },
  viewer: Viewer | null,
  mode: Mode,
): Dragged {
  const [dragged, setDragged] = useState<Dragged>(null);
  useEffect(() => {
    if (!canvas.current || !viewer) return;
    return steer(canvas.current, { viewer, turns: () => mode !== "above", onDrag: setDragged });
  }, [canvas, viewer, mode]);
  return dragged;
}
