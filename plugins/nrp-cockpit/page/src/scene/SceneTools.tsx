import { barredBy, useMissing, useRecorded, useRun } from "../state/run";
import { IconButton } from "../ui/Button";
import { Segmented, Toggles } from "../ui/Segmented";
import { type Layer, type Mode, toggleLayer, useChoices } from "./choices";
import { toggleEditing, useEditing } from "./editing";
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
      <EditSwitch />
      <IconButton icon="fit" label="Fit" shortcut="F" kind="ghost" small data-key="fit" onClick={onFit} />
    </>
  );
}

/** Whether bodies are moved and added; a run that is only watched is not. */
function EditSwitch() {
  const isOn = useEditing((editing) => editing.isOn);
  const blocked = useRun(barredBy);
  const missing = useMissing("place");
  if (useRecorded()) return null;
  return (
    <IconButton
      icon="move"
      label="Edit the room"
      kind="ghost"
      small
      aria-pressed={isOn}
      disabled={isOn ? undefined : (blocked ?? missing)}
      onClick={toggleEditing}
    />
  );
}
