import { type Edge, MarkerType, type Node } from "@xyflow/react";
import { functionOf } from "./model";
import type { Box, DesignState, WireData } from "./types";
import { carriedBy } from "./wireValue";

export type BoxNode = Node<{ box: Box }, Box["kind"]>;

const COLOURS = {
  message: "var(--accent)",
  drives: "var(--d-vermillion)",
  reads: "var(--d-green)",
  excites: "var(--d-blue)",
  inhibits: "var(--d-vermillion)",
} as const;
const MEANINGS = {
  message: "message",
  drives: "drives neurons",
  reads: "reads neurons",
  excites: "excites",
  inhibits: "inhibits",
} as const;
/** How much further a wire bends than the one before it between the same ends. */
const BEND = 0.3;

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
export function edgesOf(state: DesignState, selected: string): Edge[] {
  const drawn = new Map<string, number>();
  return state.wires.map((wire) => {
    const isSelected = (wire.part || wire.source_end) === selected || wire.target_end === selected;
    const ends = `${wire.source_end} ${wire.target_end}`;
    const before = drawn.get(ends) ?? 0;
    drawn.set(ends, before + 1);
    return {
      id: wire.id,
      source: wire.source,
      sourceHandle: wire.source_end,
      target: wire.target,
      targetHandle: wire.target_end,
      ariaLabel: `${wire.source_end} to ${wire.target_end}, ${MEANINGS[wire.kind]}`,
      selected: isSelected,
      style: { stroke: COLOURS[wire.kind], strokeWidth: isSelected ? 3 : 1.5 },
      ...(state.kind === "functions" ? { type: "live" } : {}),
      data: { part: wire.part ?? "", carries: carriedBy(wire, state.boxes) },
      ...(wire.label ? labelled(state, wire, before) : {}),
    };
  });
}

/** A wire with its label and an arrow, bent away from those before it. */
const labelled = (state: DesignState, wire: WireData, before: number) => ({
  label: wire.label,
  pathOptions: { curvature: 0.25 + BEND * before },
  ...(wire.source === wire.target ? loopOf(state, wire, before) : {}),
  markerEnd: {
    type: MarkerType.ArrowClosed,
    color: COLOURS[wire.kind],
    markerUnits: "userSpaceOnUse",
    width: 20,
    height: 20,
  },
});

/** A wire from a box to itself goes over the rows of the box. */
const loopOf = (state: DesignState, wire: WireData, before: number) => ({
  type: "loop",
  data: {
    part: wire.part ?? "",
    before,
    rows: state.boxes.find(({ id }) => id === wire.source)?.rows?.length ?? 0,
  },
});

/** The part of the model that a wire belongs to: a projection, or its end inside a function. */
export const partOfWire = (edge: Edge): string =>
  String(edge.data?.part || "") ||
  ([edge.sourceHandle, edge.targetHandle].find((end) => end && functionOf(end)) ?? "");
