import { Empty, Panel } from "../ui/Panel";

/** Events, criteria, failures and snapshots over simulated time. */
export function Timeline() {
  return (
    <Panel title="Timeline">
      <Empty>Waiting for the timeline.</Empty>
    </Panel>
  );
}
