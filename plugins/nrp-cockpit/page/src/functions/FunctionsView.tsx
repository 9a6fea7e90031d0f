import { Empty, Panel } from "../ui/Panel";

/** The transfer functions: source, findings, cost, apply. */
export default function FunctionsView() {
  return (
    <Panel title="Transfer functions">
      <Empty>Waiting for the functions.</Empty>
    </Panel>
  );
}
