import { Empty, Panel } from "../ui/Panel";

/** Curves of devices and of fields of topics. */
export function TracesPanel() {
  return (
    <Panel title="Devices and topics">
      <Empty>Drag a variable here.</Empty>
    </Panel>
  );
}
