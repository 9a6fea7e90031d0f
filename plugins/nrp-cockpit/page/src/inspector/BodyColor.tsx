import { useState, useSyncExternalStore } from "react";
import { publish } from "../state/commands";
import { notify } from "../state/notices";
import { useBlocked } from "../state/run";
import type { Body } from "../state/types";
import { Icon } from "../ui/Icon";
import { Tooltip } from "../ui/Tooltip";
import type { Rgba } from "../world/messages";
import { world } from "../world/world";
import { type ColoredPart, coloredParts, fromHex, SWATCHES, toHex } from "./color";
import { Section } from "./Facts";

const follow = (changed: () => void) => world.follow((change) => change === "scene" && changed());

/** The colour that a part has now. */
const useColor = (entity: string): string | null =>
  useSyncExternalStore(follow, () => {
    const color = world.entities.get(entity)?.shapes[0]?.color;
    return color ? toHex(color) : null;
  });

/** Gives a part of a body another colour; nothing for a body that cannot be coloured. */
export function BodyColor({ body }: { body: Body }) {
  const parts = coloredParts(body);
  const [chosen, setChosen] = useState(0);
  const part = parts[chosen] ?? parts[0];
  return part && <Colors parts={parts} part={part} onPart={setChosen} />;
}

interface ColorsProps {
  parts: readonly ColoredPart[];
  part: ColoredPart;
  onPart: (index: number) => void;
}

function Colors({ parts, part, onPart }: ColorsProps) {
  const now = useColor(part.entity);
  const blocked = useBlocked();
  const paint = (color: Rgba) => (blocked ? notify(blocked) : void publish(part.topic, color));
  return (
    <Section title="Colour">
      {parts.length > 1 && <PartChoice parts={parts} part={part} onPart={onPart} />}
      <div className="inspector-swatches">
        {SWATCHES.map(({ name, color }) => (
          <Tooltip key={name} text={blocked}>
            <button
              type="button"
              aria-pressed={toHex(color) === now}
              aria-disabled={blocked ? true : undefined}
              onClick={() => paint(color)}
            >
              <i style={{ background: toHex(color) }}>{toHex(color) === now && <Icon name="check" />}</i>
              {name}
            </button>
          </Tooltip>
        ))}
        <Tooltip text={blocked}>
          <label>
            <input
              type="color"
              value={now ?? "#000000"}
              disabled={blocked !== undefined}
              onChange={(event) => paint(fromHex(event.target.value))}
            />
            Other
          </label>
        </Tooltip>
      </div>
      <p className="dim f11">Published before the next step, and recorded.</p>
    </Section>
  );
}

/** Which part of the body gets the colour. */
function PartChoice({ parts, part, onPart }: ColorsProps) {
  return (
    <label className="inspector-part row f12 mut">
      Part
      <select
        className="input"
        value={parts.indexOf(part)}
        onChange={(event) => onPart(Number(event.target.value))}
      >
        {parts.map(({ entity }, index) => (
          <option key={entity} value={index}>
            {entity.split("/").slice(1).join("/")}
          </option>
        ))}
      </select>
    </label>
  );
}
