import { Empty, Panel } from "../ui/Panel";

/** The spike raster. */
export function SpikesPanel() {
  return (
    <Panel title="Spikes">
      <Empty>Waiting for spikes.</Empty>
    </Panel>
  );
}
