import type { Edge, Node } from "@xyflow/react";
import { functionOf } from "./model";
import type { Box, DesignState } from "./types";

export type BoxNode = Node<{ box: Box }, Box["kind"]>;

const COLOURS = { message: "var(--accent)", drives: "var(--d-vermillion)", reads: "var(--d-green)" } as const;
const MEANINGS = { message: "message", drives: "drives neurons", reads: "reads neurons" } as const;

/** The name of a box in a layout, as the server has it: functions are known by their names. */
export const keyOf = (box: Box): string =>
  box.kind === "topic" || box.kind === "population" ? box.id : box.name;

/** The boxes as React Flow takes them; those that it measured stay measured. */
export function nodesOf(state: DesignState, selected: string, before: readonly BoxNode[]): BoxNode[] {
  const known = new Map(before.map((node) => [node.id, node]));
  return state.boxes.map((box) => {
    const measured = known.get(box.id)?.measured;
    return {
      id: box.id,
      type: box.kind,
      position: { x: box.x, y: box.y },
      data: { box },
      selected: box.id === selected || box.id === functionOf(selected),
      ariaLabel: `${box.kind} ${box.name}`,
      dragHandle: ".box-head",
      ...(measured ? { measured } : {}),
    };
  });
}

/** The wires as React Flow takes them; the one of the selected part stands out. */
export const edgesOf = (state: DesignState, selected: string): Edge[] =>
  state.wires.map((wire) => {
    const isSelected = wire.source_end === selected || wire.target_end === selected;
    return {
      id: wire.id,
      source: wire.source,
      sourceHandle: wire.source_end,
      target: wire.target,
      targetHandle: wire.target_end,
      ariaLabel: `${wire.source_end} to ${wire.target_end}, ${MEANINGS[wire.kind]}`,
      selected: isSelected,
      style: { stroke: COLOURS[wire.kind], strokeWidth: isSelected ? 3 : 1.5 },
    };
  });

/** The part of the model that a wire belongs to: its end inside a function. */
export const partOfWire = (edge: Edge): string =>
  [edge.sourceHandle, edge.targetHandle].find((end) => end && functionOf(end)) ?? "";
