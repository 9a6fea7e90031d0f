import { Empty, Panel } from "../ui/Panel";

/** What the robot's camera sees. */
export function CameraPanel() {
  return (
    <Panel title="Camera">
      <Empty>Waiting for an image.</Empty>
    </Panel>
  );
}
