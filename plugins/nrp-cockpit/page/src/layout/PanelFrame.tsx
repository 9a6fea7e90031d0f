import { type DragEvent, type HTMLAttributes, useMemo } from "react";
import { useAfterPicture } from "../state/picture";
import { setFull, useView } from "../state/view";
import { Boundary } from "../ui/Boundary";
import { IconButton } from "../ui/Button";
import { Panel } from "../ui/Panel";
import { PanelContext } from "../ui/panelContext";
import { rooms } from "./rooms";
import { swap } from "./store";
import type { PanelId } from "./tree";

const DRAGGED = "application/x-nrp-panel";

const headProps = (id: PanelId): HTMLAttributes<HTMLDivElement> => ({
  draggable: true,
  onDragStart: (event) => {
    event.dataTransfer.setData(DRAGGED, id);
    event.dataTransfer.effectAllowed = "move";
  },
});

/** A place in the layout: the room that stands there, its full-size button, and its head as a handle to move it. */
export function PanelFrame({ id }: { id: PanelId }) {
  const full = useView((state) => state.full === id);
  const { component: Room, title } = rooms[id];
  const after = useAfterPicture();
  const comes = after || id === "scene";
  const frame = useMemo(
    () => ({
      headProps: headProps(id),
      frameTools: (
        <IconButton
          icon={full ? "shrink" : "expand"}
          label={full ? "Leave full size" : "Full size"}
          shortcut={full ? "Esc" : "Enter"}
          kind="ghost"
          small
          onClick={() => setFull(full ? null : id)}
        />
      ),
    }),
    [id, full],
  );
  const over = (event: DragEvent) => {
    if (event.dataTransfer.types.includes(DRAGGED)) event.preventDefault();
  };
  const drop = (event: DragEvent) => {
    const dragged = event.dataTransfer.getData(DRAGGED) as PanelId | "";
    if (dragged && dragged !== id) swap(dragged, id);
  };
  return (
    // biome-ignore lint/a11y/noStaticElementInteractions: only a place to drop on; the menu of the layout does the same
    <div className="frame" data-panel={id} tabIndex={-1} onDragOver={over} onDrop={drop}>
      <PanelContext value={frame}>
        <Boundary title={title}>{comes ? <Room /> : <Panel title={title}>{null}</Panel>}</Boundary>
      </PanelContext>
    </div>
  );
}
