import { type ComponentType, lazy } from "react";
import { BrainPanel } from "../brain/BrainPanel";
import { CameraPanel, isCamera } from "../camera/CameraPanel";
import { InspectorPanel } from "../inspector/InspectorPanel";
import { MapPanel } from "../map/MapPanel";
import { ParametersPanel } from "../parameters/ParametersPanel";
import { SpikesPanel } from "../plots/SpikesPanel";
import { TracesPanel } from "../plots/TracesPanel";
import type { Kind } from "../state/panels";
import { kindOf } from "../state/panels";
import type { Experiment } from "../state/types";
import type { Node } from "./tree";

interface Shown {
  title: string;
  component: ComponentType;
  /** Whether a run has anything for it; by default each has. */
  isFor?: (experiment: Experiment) => boolean;
}

const hasCells = ({ populations }: Experiment) => populations.length > 0;
const hasSpikes = ({ populations }: Experiment) => populations.some(({ silent }) => !silent);
const hasRoom = ({ bodies, robots }: Experiment) => bodies.length + robots.length > 0;

/** The panels of the cockpit by their kinds; the scene with three.js is fetched after the first picture. */
export const panels: Record<Kind, Shown> = {
  scene: { title: "Scene", component: lazy(() => import("../scene/ScenePanel")), isFor: hasRoom },
  camera: { title: "Camera", component: CameraPanel, isFor: ({ topics }) => topics.some(isCamera) },
  map: { title: "From above", component: MapPanel, isFor: hasRoom },
  brain: { title: "Brain", component: BrainPanel, isFor: hasCells },
  spikes: { title: "Spikes", component: SpikesPanel, isFor: hasSpikes },
  traces: { title: "Devices and topics", component: TracesPanel },
  parameters: { title: "Parameters", component: ParametersPanel, isFor: ({ source }) => source === "live" },
  inspector: { title: "Selected", component: InspectorPanel },
};

/** Whether a run has anything to show in a panel, or in one of several; all may have until it is described. */
export function isShown(node: Node, experiment: Experiment | null): boolean {
  if (typeof node !== "string") return node.parts.some((part) => isShown(part, experiment));
  return experiment === null || (panels[kindOf(node)].isFor?.(experiment) ?? true);
}
