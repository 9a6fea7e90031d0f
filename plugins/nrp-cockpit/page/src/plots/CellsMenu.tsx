import { Icon, type IconName } from "../ui/Icon";
import { Menu } from "../ui/Menu";
import type { Look } from "./spikesPicture";

interface CellsProps {
  look: Look;
  onLook: (look: Look) => void;
  /** Shows fewer cells (below 1) or more; null: all. */
  onZoom: (factor: number | null) => void;
}

const STEP = 2;
const chosen = (is: boolean): { icon?: IconName } => (is ? { icon: "check" } : {});

/** Which cells are drawn, in which order and how high. */
export function CellsMenu({ look, onLook, onZoom }: CellsProps) {
  const { order, each } = look;
  const items = [
    {
      label: "By number",
      ...chosen(order === "number"),
      onSelect: () => onLook({ ...look, order: "number" }),
    },
    {
      label: "Active cells first, silent ones hidden",
      ...chosen(order === "active"),
      onSelect: () => onLook({ ...look, order: "active" }),
    },
    { label: "Heat of groups", ...chosen(!each), onSelect: () => onLook({ ...look, each: false }) },
    { label: "Heat of cells", ...chosen(each), onSelect: () => onLook({ ...look, each: true }) },
    { label: "Fewer cells, higher", icon: "plus" as const, onSelect: () => onZoom(1 / STEP) },
    { label: "More cells, lower", icon: "minus" as const, onSelect: () => onZoom(STEP) },
    { label: "All cells", icon: "fit" as const, onSelect: () => onZoom(null) },
  ];
  return (
    <span className="plot-cells">
      <Menu label="Cells in the plot" items={items} className="btn btn-ghost btn-small">
        Cells
        <Icon name="down" small />
      </Menu>
    </span>
  );
}
