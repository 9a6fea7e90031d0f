import { PANELS } from "../state/panels";
import { barredBy, useRun } from "../state/run";
import { Icon } from "../ui/Icon";
import { Menu } from "../ui/Menu";
import { isPlayed } from "../wire/recording";
import { isShown, panels } from "./panels";
import { add, presetLayout, resetLayout } from "./store";

/** What can be done with the layout as a whole. */
export function LayoutMenu() {
  const barred = useRun(barredBy);
  const experiment = useRun((run) => run.experiment);
  const kinds = PANELS.filter((kind) => isShown(kind, experiment));
  const items = [
    ...kinds.map((kind) => ({ label: `Add ${panels[kind].title}`, onSelect: () => add(kind) })),
    { label: "Reset the layout", onSelect: () => void resetLayout() },
    ...(isPlayed()
      ? []
      : [{ label: "Save as preset", disabled: barred, onSelect: () => void presetLayout() }]),
  ];
  return (
    <Menu label="Layout" items={items} className="">
      <Icon name="cockpit" />
      Layout
    </Menu>
  );
}
