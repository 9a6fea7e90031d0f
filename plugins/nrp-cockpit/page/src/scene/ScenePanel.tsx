import { Empty, Panel } from "../ui/Panel";

/** The world in three dimensions. */
export default function ScenePanel() {
  return (
    <Panel title="Scene">
      <Empty>Waiting for the scene.</Empty>
    </Panel>
  );
}
