import { type ReactNode, useEffect, useId, useRef } from "react";
import { labelOf } from "./model";
import { actHere, named, useDesign } from "./store";
import type { Feature, NodeData } from "./types";

interface PartProps {
  path: string;
  feature: Feature;
  part: NodeData | null;
  /** The form of the part. */
  children: ReactNode;
}

const below = (path: string, field: string) => (path ? `${path}/${field}` : field);

/** What a new intervention has the focus at, as it has no name. */
const UNNAMED = "effect";

/** A part of one of several classes: the class, and the form of it; without one, what it could be. */
export function PartField({ path, feature, part, children }: PartProps) {
  const choices = useDesign((design) => design.metamodel?.classes[feature.of]?.choices) ?? [];
  const here = below(path, feature.field);
  const id = useId();
  const field = useRef<HTMLSelectElement>(null);
  const isNew = useDesign((design) => design.isNew && design.selected === path && feature.field === UNNAMED);
  useEffect(() => {
    if (!isNew) return;
    field.current?.focus();
    named();
  }, [isNew]);
  const choose = (type: string) => {
    if (type === "") void actHere("remove", { path: here });
    else if (part) void actHere("become", { path: here, type });
    else void actHere("add", { path, field: feature.field, type });
  };
  return (
    <fieldset className="form-part">
      <div className="field">
        <label htmlFor={id}>{labelOf(feature)}</label>
        <span className="form-value">
          <select
            id={id}
            ref={field}
            className="input"
            value={part?.type ?? ""}
            onChange={(event) => choose(event.target.value)}
          >
            {feature.least === 0 && <option value="">none</option>}
            {choices.map((choice) => (
              <option key={choice}>{choice}</option>
            ))}
          </select>
          {part?.text && <span className="form-unit mono">{part.text}</span>}
        </span>
      </div>
      {children}
    </fieldset>
  );
}
