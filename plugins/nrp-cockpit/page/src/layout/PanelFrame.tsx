import { type DragEvent, type HTMLAttributes, Suspense, useContext, useMemo, useState } from "react";
import { PanelContext } from "../state/panelContext";
import { kindOf, numberOf, type PanelId } from "../state/panels";
import { useAfterPicture } from "../state/picture";
import { useView } from "../state/view";
import { Boundary } from "../ui/Boundary";
import { Panel } from "../ui/Panel";
import { FrameTools } from "./FrameTools";
import { panels } from "./panels";
import { moveTo, swap } from "./store";
import type { Side } from "./tree";

const DRAGGED = "application/x-nrp-panel";

const headProps = (id: PanelId): HTMLAttributes<HTMLDivElement> => ({
  draggable: true,
  onDragStart: (event) => {
    event.dataTransfer.setData(DRAGGED, id);
    event.dataTransfer.effectAllowed = "move";
  },
});

interface FrameProps {
  id: PanelId;
  /** Whether it stays where it is. */
  fixed?: boolean;
}

/** A place in the layout: the panel that stands there, its tools, and its head as a handle to move it. */
export function PanelFrame({ id, fixed = false }: FrameProps) {
  const full = useView((state) => state.full === id);
  const { component: Content, title } = panels[kindOf(id)];
  const after = useAfterPicture();
  const comes = after || kindOf(id) === "scene";
  const { drop, ...handlers } = useDrop(id);
  const frame = useMemo(
    () => ({
      id,
      number: numberOf(id),
      headProps: fixed ? {} : headProps(id),
      frameTools: fixed ? null : <FrameTools id={id} full={full} />,
    }),
    [id, full, fixed],
  );
  return (
    <div className="frame" data-panel={id} data-drop={drop} tabIndex={-1} {...(fixed ? {} : handlers)}>
      <PanelContext value={frame}>
        <Boundary title={title}>
          {comes ? (
            <Suspense fallback={<Coming title={title} />}>
              <Content />
            </Suspense>
          ) : (
            <Coming title={title} />
          )}
        </Boundary>
      </PanelContext>
    </div>
  );
}

/** Keeps the place of a panel until it comes, without tools: a click on them would be lost with it. */
function Coming({ title }: { title: string }) {
  const frame = useContext(PanelContext);
  const bare = useMemo(() => ({ ...frame, headProps: {}, frameTools: null }), [frame]);
  return (
    <PanelContext value={bare}>
      <Panel title={title}>{null}</Panel>
    </PanelContext>
  );
}

type Drop = Side | "swap";

/** Beyond this share of a panel from its middle, another is dropped beside it, and otherwise in its place. */
const BESIDE = 0.25;

function dropAt({ clientX, clientY, currentTarget }: DragEvent): Drop {
  const { left, top, width, height } = currentTarget.getBoundingClientRect();
  const x = (clientX - left) / width - 0.5;
  const y = (clientY - top) / height - 0.5;
  if (Math.max(Math.abs(x), Math.abs(y)) < BESIDE) return "swap";
  if (Math.abs(x) > Math.abs(y)) return x < 0 ? "left" : "right";
  return y < 0 ? "above" : "below";
}

/** Takes panels that are dropped; says where one would go. */
function useDrop(id: PanelId) {
  const [drop, setDrop] = useState<Drop>();
  return {
    drop,
    onDragOver: (event: DragEvent) => {
      if (!event.dataTransfer.types.includes(DRAGGED)) return;
      event.preventDefault();
      setDrop(dropAt(event));
    },
    onDragLeave: ({ currentTarget, relatedTarget }: DragEvent) => {
      if (!currentTarget.contains(relatedTarget as globalThis.Node | null)) setDrop(undefined);
    },
    onDrop: (event: DragEvent) => {
      setDrop(undefined);
      const dragged = event.dataTransfer.getData(DRAGGED) as PanelId | "";
      if (!dragged || dragged === id) return;
      const where = dropAt(event);
      if (where === "swap") swap(dragged, id);
      else moveTo(dragged, id, where);
    },
  };
}
