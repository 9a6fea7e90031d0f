import { IconButton } from "../ui/Button";
import { Segmented, Toggles } from "../ui/Segmented";
import { type Layer, type Mode, toggleLayer, useChoices } from "./choices";
import { useOfferedLayers } from "./useSights";

const MODES: { value: Mode; label: string }[] = [
  { value: "orbit", label: "Orbit" },
  { value: "follow", label: "Follow" },
  { value: "above", label: "From above" },
];

const LAYERS: { value: Layer; label: string }[] = [
  { value: "frustum", label: "Frustum" },
  { value: "rays", label: "Rays" },
  { value: "contacts", label: "Contacts" },
  { value: "trail", label: "Trail" },
];

interface ToolsProps {
  mode: Mode;
  onMode: (mode: Mode) => void;
  onFit: () => void;
}

/** The controls in the head of the scene. */
export function SceneTools({ mode, onMode, onFit }: ToolsProps) {
  const layers = useChoices((choices) => choices.layers);
  const offered = useOfferedLayers();
  const choices = LAYERS.filter(({ value }) => offered.has(value));
  return (
    <>
      <Segmented label="View" choices={MODES} value={mode} onChange={onMode} />
      <Toggles label="Shown" choices={choices} on={layers} onToggle={toggleLayer} />
      <IconButton icon="fit" label="Fit" shortcut="F" kind="ghost" small data-key="fit" onClick={onFit} />
    </>
  );
}
