import { useState, useSyncExternalStore } from "react";
import { publish } from "../state/commands";
import { useBlocked } from "../state/run";
import type { Body } from "../state/types";
import { Icon } from "../ui/Icon";
import { Tooltip } from "../ui/Tooltip";
import type { Rgba } from "../world/messages";
import { world } from "../world/world";
import { colorTopics, entityOfTopic, fromHex, SWATCHES, toHex } from "./color";
import { Section } from "./Facts";

const follow = (changed: () => void) => world.follow((change) => change === "scene" && changed());

/** The colour that a part has now. */
const useColor = (entity: string): string | null =>
  useSyncExternalStore(follow, () => {
    const color = world.entities.get(entity)?.shapes[0]?.color;
    return color ? toHex(color) : null;
  });

/** Gives a part of a body another colour. */
export function BodyColor({ body }: { body: Body }) {
  const topics = colorTopics(body.topics);
  const [topic, setTopic] = useState(body.colorable ?? topics[0] ?? "");
  const now = useColor(entityOfTopic(topic));
  const blocked = useBlocked();
  const paint = (color: Rgba) => {
    if (blocked === undefined) void publish(topic, color);
  };
  return (
    <Section title="Colour">
      {topics.length > 1 && <Part topics={topics} topic={topic} onTopic={setTopic} />}
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

interface PartProps {
  topics: readonly string[];
  topic: string;
  onTopic: (topic: string) => void;
}

/** Which part of the body gets the colour. */
function Part({ topics, topic, onTopic }: PartProps) {
  return (
    <label className="inspector-part row f12 mut">
      Part
      <select className="input" value={topic} onChange={(event) => onTopic(event.target.value)}>
        {topics.map((one) => (
          <option key={one} value={one}>
            {entityOfTopic(one).split("/").slice(1).join("/")}
          </option>
        ))}
      </select>
    </label>
  );
}
