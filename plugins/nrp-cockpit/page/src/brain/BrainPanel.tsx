import { Empty, Panel } from "../ui/Panel";

/** Populations and projections as a graph; activity as brightness. */
export function BrainPanel() {
  return (
    <Panel title="Brain">
      <Empty>Waiting for the populations.</Empty>
    </Panel>
  );
}
