import { IconButton } from "../ui/Button";
import { Segmented, Toggles } from "../ui/Segmented";
import { type Layer, type Mode, setMode, toggleLayer, useChoices } from "./choices";
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

/** The controls in the head of the scene. */
export function SceneTools({ onFit }: { onFit: () => void }) {
  const mode = useChoices((choices) => choices.mode);
  const layers = useChoices((choices) => choices.layers);
  const offered = useOfferedLayers();
  const choices = LAYERS.filter(({ value }) => offered.has(value));
  return (
    <>
      <Segmented label="View" choices={MODES} value={mode} onChange={setMode} />
      <Toggles label="Shown" choices={choices} on={layers} onToggle={toggleLayer} />
      <IconButton icon="fit" label="Fit" shortcut="F" kind="ghost" small data-key="fit" onClick={onFit} />
    </>
  );
}
