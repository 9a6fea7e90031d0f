import { Empty, Panel } from "../ui/Panel";

/** The room from above, with the robot's path. */
export function MapPanel() {
  return (
    <Panel title="From above">
      <Empty>Waiting for the scene.</Empty>
    </Panel>
  );
}
