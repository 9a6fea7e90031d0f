import { Handle, Position } from "@xyflow/react";
import { useDesign } from "./store";

interface EndProps {
  /** The end, as the server names it. */
  id: string;
  label: string;
  side: "left" | "right";
  look: "message" | "drives" | "reads" | "free";
  /** Whether no wire can be drawn to it. */
  fixed?: boolean;
}

/** Where wires begin and end; while one is drawn, ends that fit grow and the others fade. */
export function End({ id, label, side, look, fixed = false }: EndProps) {
  const refusal = useDesign(({ refusals }) => refusals?.[id]);
  const fit = refusal === undefined ? undefined : refusal === null ? "yes" : "no";
  return (
    <Handle
      id={id}
      type="source"
      position={side === "left" ? Position.Left : Position.Right}
      isConnectable={!fixed}
      role={fixed ? "img" : "button"}
      aria-label={`Wire of ${label}`}
      className={`end end-${look}`}
      data-fit={fit}
    />
  );
}
