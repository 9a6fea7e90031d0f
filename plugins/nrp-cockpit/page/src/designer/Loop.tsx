import { BaseEdge, type EdgeProps } from "@xyflow/react";

const WIDTH = 72;
/** Of the points that bend the wire, which itself goes three quarters of the way; the rows of a box come on top. */
const HEIGHT = 80;
const ROW = 38;
const APART = 32;

/** A wire from a box to itself: over its top, each further one higher. */
export function Loop({ sourceX, sourceY, targetX, targetY, data, label, markerEnd, style }: EdgeProps) {
  const rows = ROW * Number(data?.rows ?? 0) + APART * Number(data?.before ?? 0);
  const top = Math.min(sourceY, targetY) - HEIGHT - rows;
  const path = `M ${sourceX} ${sourceY} C ${sourceX + WIDTH} ${top}, ${targetX - WIDTH} ${top}, ${targetX} ${targetY}`;
  const middle = (sourceY + targetY + 6 * top) / 8;
  return (
    <BaseEdge
      path={path}
      label={label}
      labelX={(sourceX + targetX) / 2}
      labelY={middle}
      {...(markerEnd ? { markerEnd } : {})}
      {...(style ? { style } : {})}
    />
  );
}
