/** The colours of the theme for drawing on a canvas, read from the custom properties of the page. */
export interface Palette {
  panel: string;
  hover: string;
  line: string;
  grid: string;
  text: string;
  text2: string;
  text3: string;
  accent: string;
  accentSoft: string;
  sensor: string;
  circuit: string;
  actor: string;
  /** The colours of curves, in the order in which they are given. */
  curves: readonly string[];
  /** The font of small print. */
  font: string;
}

export const CURVE_COLOURS = [
  "--d-blue",
  "--d-vermillion",
  "--d-green",
  "--d-purple",
  "--d-orange",
  "--d-sky",
];

export function readPalette(): Palette {
  const style = getComputedStyle(document.documentElement);
  const colour = (name: string) => style.getPropertyValue(name).trim();
  return {
    panel: colour("--panel"),
    hover: colour("--hover"),
    line: colour("--line"),
    grid: colour("--grid"),
    text: colour("--text"),
    text2: colour("--text-2"),
    text3: colour("--text-3"),
    accent: colour("--accent"),
    accentSoft: colour("--accent-soft"),
    sensor: colour("--d-blue"),
    circuit: colour("--d-vermillion"),
    actor: colour("--d-green"),
    curves: CURVE_COLOURS.map(colour),
    font: `11px ${getComputedStyle(document.body).fontFamily}`,
  };
}
