import { SplitView } from "../layout/SplitView";
import type { Split } from "../layout/tree";
import { Notices } from "../shell/Notices";
import "../layout/layout.css";
import "../shell/shell.css";
import "./compare.css";

const SHOWN: Split = {
  direction: "row",
  sizes: [1.5, 1],
  parts: ["scene", { direction: "column", sizes: [1, 1], parts: ["spikes", "inspector"] }],
};

/** One of two runs: its scene, its spikes, and what is selected. */
export default function EmbeddedView() {
  return (
    <main id="main" className="embedded">
      <SplitView node={SHOWN} fixed />
      <Notices />
    </main>
  );
}
