import { useConnection } from "@xyflow/react";
import { Icon } from "../ui/Icon";
import { useDesign } from "./store";

/** Why a wire does not fit: while it is held over an end, and for a while where it was dropped. */
export function Refused() {
  const refused = useDesign((design) => design.refused);
  const refusals = useDesign((design) => design.refusals);
  const over = useConnection((connection) => connection.toHandle?.id ?? null);
  const held = over === null ? null : refusals?.[over];
  const reason = held ?? refused?.reason;
  if (!reason) return <div role="status" className="refused-none" />;
  const at = held || !refused ? undefined : { left: refused.x, top: refused.y };
  return (
    <div className={at ? "refused" : "refused refused-held"} role="status" style={at}>
      <b>
        <Icon name="error" small />
        Cannot connect
      </b>
      {reason}
    </div>
  );
}
