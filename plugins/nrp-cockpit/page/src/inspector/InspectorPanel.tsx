import { Empty, Panel } from "../ui/Panel";

/** What is selected: its values, and what may be done with it. */
export function InspectorPanel() {
  return (
    <Panel title="Selected">
      <Empty>Click a body, a cell or a projection.</Empty>
    </Panel>
  );
}
