import { savingItems } from "../saving/items";
import { kindOf, numberOf, PANELS, type PanelId } from "../state/panels";
import { useRun } from "../state/run";
import { setFull } from "../state/view";
import { IconButton } from "../ui/Button";
import { Icon } from "../ui/Icon";
import { Menu } from "../ui/Menu";
import { isShown, panels } from "./panels";
import { become, close, split, useLayout } from "./store";
import { panelsOf } from "./tree";

/** The buttons of a panel: full size, and what can be done with its place. */
export function FrameTools({ id, full }: { id: PanelId; full: boolean }) {
  const experiment = useRun((run) => run.experiment);
  const last = useLayout(({ tree }) => panelsOf(tree).length === 1);
  const kind = kindOf(id);
  const number = numberOf(id);
  const others = PANELS.filter((one) => one !== kind && isShown(one, experiment));
  const items = () => [
    { label: "Full size", shortcut: "Enter", onSelect: () => setFull(id) },
    { label: "Split to the right", onSelect: () => split(id, "right") },
    { label: "Split below", onSelect: () => split(id, "below") },
    ...others.map((one) => ({
      label: `Show ${panels[one].title} here`,
      onSelect: () => become(id, one),
    })),
    ...savingItems(id),
    {
      label: "Close",
      disabled: last ? "It is the last panel." : undefined,
      onSelect: () => close(id),
    },
  ];
  const name = `${panels[kind].title}${number > 1 ? ` ${number}` : ""}`;
  return (
    <>
      {!full && (
        <Menu label={`Place of ${name}`} items={items} className="btn btn-small btn-ghost btn-icon">
          <Icon name="more" />
        </Menu>
      )}
      <IconButton
        icon={full ? "shrink" : "expand"}
        label={full ? "Leave full size" : "Full size"}
        shortcut={full ? "Esc" : "Enter"}
        kind="ghost"
        small
        onClick={() => setFull(full ? null : id)}
      />
    </>
  );
}
