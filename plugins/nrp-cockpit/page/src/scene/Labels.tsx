import { useEffect, useRef } from "react";
import { Vector3 } from "three";
import { useRun } from "../state/run";
import { select, useSelection } from "../state/selection";
import type { Viewer } from "./viewer";

const NO_ROBOTS: readonly string[] = [];

/** The names of the robots and of the selected body, over them; a click on a name selects. */
export function Labels({ viewer }: { viewer: Viewer }) {
  const robots = useRun((run) => run.experiment?.robots ?? NO_ROBOTS);
  const selected = useSelection(({ selected: one }) => (one?.kind === "body" ? one.name : null));
  const names = new Set(selected === null ? robots : [...robots, selected]);
  return [...names].map((name) => (
    <Label key={name} viewer={viewer} body={name} selected={name === selected} />
  ));
}

function Label({ viewer, body, selected }: { viewer: Viewer; body: string; selected: boolean }) {
  const label = useRef<HTMLDivElement>(null);
  useEffect(() => {
    const place = (width: number, height: number) => {
      const { current } = label;
      if (!current) return;
      const box = viewer.bodies.boxOf(viewer.bodies.of(body));
      const top = box.getCenter(new Vector3()).setZ(box.max.z).project(viewer.camera);
      current.hidden = box.isEmpty() || top.z > 1 || Math.abs(top.x) > 1 || Math.abs(top.y) > 1;
      current.style.transform = `translate(${((top.x + 1) * width) / 2}px, ${((1 - top.y) * height) / 2}px)`;
    };
    viewer.invalidate();
    return viewer.onDrawn(place);
  }, [viewer, body]);
  return (
    <div ref={label} className="scene-label">
      <button type="button" aria-pressed={selected} onClick={() => select({ kind: "body", name: body })}>
        {body}
      </button>
    </div>
  );
}
