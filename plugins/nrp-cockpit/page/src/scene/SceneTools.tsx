import { IconButton } from "../ui/Button";
import { Segmented, Toggles } from "../ui/Segmented";
import type { Mode } from "./steering";

export type Layer = "trail";

const MODES: { value: Mode; label: string }[] = [
  { value: "orbit", label: "Orbit" },
  { value: "follow", label: "Follow" },
  { value: "above", label: "From above" },
];

const LAYERS: { value: Layer; label: string }[] = [{ value: "trail", label: "Trail" }];

interface SceneToolsProps {
  mode: Mode;
  onMode: (mode: Mode) => void;
  layers: ReadonlySet<Layer>;
  onLayer: (layer: Layer) => void;
  onFit: () => void;
}

/** The controls in the head of the scene. */
export function SceneTools({ mode, onMode, layers, onLayer, onFit }: SceneToolsProps) {
  return (
    <>
      <Segmented label="View" choices={MODES} value={mode} onChange={onMode} />
      <Toggles label="Shown" choices={LAYERS} on={layers} onToggle={onLayer} />
      <IconButton icon="fit" label="Fit" shortcut="F" kind="ghost" small data-key="fit" onClick={onFit} />
    </>
  );
}
