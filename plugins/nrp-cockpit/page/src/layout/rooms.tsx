import { type ComponentType, lazy } from "react";
import { BrainPanel } from "../brain/BrainPanel";
import { CameraPanel } from "../camera/CameraPanel";
import { InspectorPanel } from "../inspector/InspectorPanel";
import { MapPanel } from "../map/MapPanel";
import { SpikesPanel } from "../plots/SpikesPanel";
import { TracesPanel } from "../plots/TracesPanel";
import type { PanelId } from "./tree";

interface Room {
  title: string;
  component: ComponentType;
}

/** The rooms of the cockpit by the ids of the layout; the scene with three.js is fetched after the first picture. */
export const rooms: Record<PanelId, Room> = {
  scene: { title: "Scene", component: lazy(() => import("../scene/ScenePanel")) },
  camera: { title: "Camera", component: CameraPanel },
  map: { title: "From above", component: MapPanel },
  brain: { title: "Brain", component: BrainPanel },
  spikes: { title: "Spikes", component: SpikesPanel },
  traces: { title: "Devices and topics", component: TracesPanel },
  inspector: { title: "Selected", component: InspectorPanel },
};
