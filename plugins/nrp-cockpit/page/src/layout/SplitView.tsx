import { Fragment, type KeyboardEvent, type PointerEvent } from "react";
import { PanelFrame } from "./PanelFrame";
import { resize } from "./store";
import type { Node, Path, Split } from "./tree";

/** A row or column of panels, with a border to drag between each two. */
export function SplitView({ node, path = [] }: { node: Node; path?: Path }) {
  if (typeof node === "string") return <PanelFrame id={node} />;
  return (
    <div className={`split split-${node.direction}`}>
      {node.parts.map((part, index) => (
        <Fragment key={typeof part === "string" ? part : `split-${index}`}>
          {index > 0 && <Border split={node} path={path} index={index - 1} />}
          <div className="split-part" style={{ flexGrow: node.sizes[index] }}>
            <SplitView node={part} path={[...path, index]} />
          </div>
        </Fragment>
      ))}
    </div>
  );
}

const KEY_STEP = 0.02;

interface BorderProps {
  split: Split;
  path: Path;
  /** The number of the part before the border. */
  index: number;
}

/** Drag it, or move it with the arrows. */
function Border({ split, path, index }: BorderProps) {
  const row = split.direction === "row";
  const before = split.sizes[index] ?? 1;
  const share = before / (before + (split.sizes[index + 1] ?? 1));
  const drag = (event: PointerEvent<HTMLElement>) => {
    if (!event.currentTarget.hasPointerCapture(event.pointerId)) return;
    const a = event.currentTarget.previousElementSibling?.getBoundingClientRect();
    const b = event.currentTarget.nextElementSibling?.getBoundingClientRect();
    if (!a || !b) return;
    const now = row
      ? (event.clientX - a.left) / (b.right - a.left)
      : (event.clientY - a.top) / (b.bottom - a.top);
    resize(path, index, now - share);
  };
  const key = (event: KeyboardEvent<HTMLElement>) => {
    const keys = row ? ["ArrowLeft", "ArrowRight"] : ["ArrowUp", "ArrowDown"];
    if (!keys.includes(event.key)) return;
    event.preventDefault();
    resize(path, index, event.key === keys[0] ? -KEY_STEP : KEY_STEP);
  };
  return (
    // biome-ignore lint/a11y/useSemanticElements: an <hr> takes no focus; this is the window splitter of ARIA
    <div
      className="split-border"
      role="separator"
      tabIndex={0}
      aria-label="Border between panels"
      aria-orientation={row ? "vertical" : "horizontal"}
      aria-valuenow={Math.round(share * 100)}
      onPointerDown={(event) => event.currentTarget.setPointerCapture(event.pointerId)}
      onPointerMove={drag}
      onKeyDown={key}
    />
  );
}
