import { LENGTHS_S, setWindowLength, useTimeWindow } from "../state/timeWindow";
import { IconButton } from "../ui/Button";
import { Icon } from "../ui/Icon";
import { Menu } from "../ui/Menu";
import { valueText } from "./timeAxis";
import { pauseOrFollow } from "./useTimeNavigation";

/** How long the window of the plots is, and whether it follows the run. */
export function WindowTools({ plot }: { plot: string }) {
  const length_s = useTimeWindow((window) => window.length_s);
  const held = useTimeWindow((window) => window.held_s !== null);
  const shown = `${Number(valueText(length_s))} s`;
  const items = LENGTHS_S.map((each_s) => ({
    label: `${each_s} s`,
    onSelect: () => setWindowLength(each_s),
  }));
  return (
    <>
      <Menu label={`Time window of ${plot}: ${shown}`} items={items} className="btn btn-small num">
        {shown}
        <Icon name="down" small />
      </Menu>
      <IconButton
        icon={held ? "play" : "pause"}
        label={held ? `Resume the ${plot}` : `Freeze the ${plot}; the run continues`}
        kind="ghost"
        small
        aria-pressed={held}
        onClick={pauseOrFollow}
      />
    </>
  );
}
