import {
  Background,
  BackgroundVariant,
  ConnectionMode,
  Controls,
  type FinalConnectionState,
  ReactFlow,
  useNodesState,
  useReactFlow,
  useUpdateNodeInternals,
} from "@xyflow/react";
import "@xyflow/react/dist/base.css";
import "./wires.css";
import { useEffect, useMemo } from "react";
import { boxTypes } from "./boxes";
import { type BoxNode, edgesOf, keyOf, nodesOf, partOfWire } from "./flow";
import { Legend } from "./Legend";
import { LiveWire } from "./LiveWire";
import { Loop } from "./Loop";
import { Refused } from "./Refused";
import { beginWire, endWire, leaveField, place, select, useDesign } from "./store";
import type { DesignState } from "./types";

const pointOf = (event: MouseEvent | TouchEvent) =>
  "clientX" in event ? event : (event.changedTouches[0] ?? { clientX: 0, clientY: 0 });

/** Where a wire was dropped: on an end, or anywhere on the box or row that it belongs to. */
function endAt(event: MouseEvent | TouchEvent, { toHandle }: FinalConnectionState): string | null {
  const { clientX, clientY } = pointOf(event);
  const below = document.elementFromPoint(clientX, clientY)?.closest<HTMLElement>("[data-end]");
  return toHandle?.id ?? below?.dataset.end ?? null;
}

const EDGE_TYPES = { loop: Loop, live: LiveWire };

/** The legend and the controls stand at the foot. */
const FIT = { padding: { top: "24px", left: "24px", right: "24px", bottom: "52px" }, maxZoom: 1 } as const;

/** The boxes and wires; dragging from one end to another draws a wire, dragging a head moves its box. */
export function Canvas({ state }: { state: DesignState }) {
  const selected = useDesign((design) => design.selected);
  const [nodes, setNodes, onNodesChange] = useNodesState<BoxNode>([]);
  const { fitView } = useReactFlow();
  useEffect(() => setNodes((before) => nodesOf(state, selected, before)), [state, selected, setNodes]);
  const measure = useUpdateNodeInternals();
  useEffect(() => measure(state.boxes.map(({ id }) => id)), [state, measure]);
  const edges = useMemo(() => edgesOf(state, selected), [state, selected]);
  const boxes = state.boxes.reduce((sum, box) => sum + 1 + (box.rows?.length ?? 0), 0);
  const count = state.kind === "brain" ? boxes + state.wires.length : boxes; // there, wires move boxes
  const { file } = state;
  useEffect(() => {
    if (count > 0 && file) window.setTimeout(() => void fitView(FIT), 60);
  }, [file, count, fitView]);
  const drop = (event: MouseEvent | TouchEvent, connection: FinalConnectionState) => {
    const { clientX, clientY } = pointOf(event);
    const source = connection.fromHandle?.id;
    if (source) void endWire(source, endAt(event, connection), clientX, clientY);
  };
  return (
    <div className="canvas">
      <ReactFlow<BoxNode>
        nodes={nodes}
        edges={edges}
        nodeTypes={boxTypes}
        edgeTypes={EDGE_TYPES}
        onNodesChange={onNodesChange}
        onNodeDragStart={leaveField}
        onNodeDragStop={(_event, node) => void place(keyOf(node.data.box), node.position.x, node.position.y)}
        onEdgeClick={(_event, edge) => select(partOfWire(edge))}
        onPaneClick={() => select("")}
        onConnectStart={(_event, { handleId }) => handleId && void beginWire(handleId)}
        onConnectEnd={drop}
        connectionMode={ConnectionMode.Loose}
        deleteKeyCode={null}
        multiSelectionKeyCode={null}
        fitView
        fitViewOptions={FIT}
        minZoom={0.25}
        maxZoom={2}
        proOptions={{ hideAttribution: true }}
      >
        <Background variant={BackgroundVariant.Dots} gap={16} size={1} color="var(--line)" />
        <Controls showInteractive={false} position="bottom-right" orientation="horizontal" />
      </ReactFlow>
      <Legend kind={state.kind} />
      <Refused />
    </div>
  );
}
