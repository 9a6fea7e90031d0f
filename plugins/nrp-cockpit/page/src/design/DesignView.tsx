import { Empty, Panel } from "../ui/Panel";

/** The model as boxes and wires. */
export default function DesignView() {
  return (
    <Panel title="Designer">
      <Empty>No model is open.</Empty>
    </Panel>
  );
}
