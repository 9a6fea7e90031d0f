import { Fragment, type KeyboardEvent, type PointerEvent } from "react";
import { useRun } from "../state/run";
import { PanelFrame } from "./PanelFrame";
import { isShown } from "./panels";
import { resize } from "./store";
import type { Node, Path, Split } from "./tree";

interface ViewProps {
  node: Node;
  path?: Path;
  /** Whether its panels stay where they are. */
  fixed?: boolean;
}

/** A row or column of the panels that the run has anything for, with a border to drag between each two. */
export function SplitView({ node, path = [], fixed = false }: ViewProps) {
  const experiment = useRun((run) => run.experiment);
  if (typeof node === "string") return <PanelFrame id={node} fixed={fixed} />;
  const shown = node.parts.flatMap((part, at) => (isShown(part, experiment) ? [{ part, at }] : []));
  return (
    <div className={`split split-${node.direction}`}>
      {shown.map(({ part, at }, index) => {
        const before = shown[index - 1]?.at;
        return (
          <Fragment key={typeof part === "string" ? part : `split-${at}`}>
            {before !== undefined && <Border split={node} path={path} between={[before, at]} fixed={fixed} />}
            <div className="split-part" style={{ flexGrow: node.sizes[at] }}>
              <SplitView node={part} path={[...path, at]} fixed={fixed} />
            </div>
          </Fragment>
        );
      })}
    </div>
  );
}

const KEY_STEP = 0.02;

interface BorderProps {
  split: Split;
  path: Path;
  /** The numbers of the parts on both sides. */
  between: readonly [number, number];
  fixed: boolean;
}

/** Drag it, or move it with the arrows. */
function Border({ split, path, between, fixed }: BorderProps) {
  const row = split.direction === "row";
  const [before = 1, after = 1] = between.map((at) => split.sizes[at]);
  const share = before / (before + after);
  const drag = (event: PointerEvent<HTMLElement>) => {
    if (!event.currentTarget.hasPointerCapture(event.pointerId)) return;
    const a = event.currentTarget.previousElementSibling?.getBoundingClientRect();
    const b = event.currentTarget.nextElementSibling?.getBoundingClientRect();
    if (!a || !b) return;
    const now = row
      ? (event.clientX - a.left) / (b.right - a.left)
      : (event.clientY - a.top) / (b.bottom - a.top);
    resize(path, between, now - share);
  };
  const key = (event: KeyboardEvent<HTMLElement>) => {
    const keys = row ? ["ArrowLeft", "ArrowRight"] : ["ArrowUp", "ArrowDown"];
    if (!keys.includes(event.key)) return;
    event.preventDefault();
    resize(path, between, event.key === keys[0] ? -KEY_STEP : KEY_STEP);
  };
  if (fixed) return <div className="split-border" data-fixed />;
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
