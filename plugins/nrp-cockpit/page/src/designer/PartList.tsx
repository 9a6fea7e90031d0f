import { Button } from "../ui/Button";
import { labelOf, titleOf } from "./model";
import { act, select } from "./store";
import type { Feature, NodeData } from "./types";

interface ListProps {
  path: string;
  feature: Feature;
  parts: readonly NodeData[];
}

/** The items of a list by their names; a click shows the form of one. */
export function PartList({ path, feature, parts }: ListProps) {
  const here = path ? `${path}/${feature.field}` : feature.field;
  return (
    <div className="field form-list">
      <span>{labelOf(feature)}</span>
      <span className="form-items">
        {parts.map((part, at) => (
          // biome-ignore lint/suspicious/noArrayIndexKey: an item is known by its place
          <button key={at} type="button" className="chip mono" onClick={() => select(`${here}/${at}`)}>
            {titleOf(part)}
          </button>
        ))}
        <Button
          kind="ghost"
          small
          icon="plus"
          aria-label={`Add ${labelOf(feature)}`}
          onClick={() => void act("add", { path, field: feature.field })}
        />
      </span>
    </div>
  );
}
