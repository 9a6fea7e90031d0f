import { Empty, Panel } from "../ui/Panel";

/** The same experiment on two pairs of backends, side by side. */
export default function CompareView() {
  return (
    <Panel title="Compare">
      <Empty>Choose two pairs of backends.</Empty>
    </Panel>
  );
}
