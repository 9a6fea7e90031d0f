import { setFont } from "../plots/pen";
import type { Pen, Sheet } from "../plots/useCanvas";
import type { Rgba } from "../world/messages";
import { type Pose, yawOf } from "../world/pose";
import type { Trail } from "../world/trail";
import type { Footprint, Point } from "./footprint";
import { isGround } from "./plan";
import { barLength, lengthText, type MapView, toCanvas } from "./projection";

/** What a map shows. */
export interface MapPicture {
  view: MapView;
  still: readonly Footprint[];
  moving: readonly Footprint[];
  selected: string | null;
  robots: readonly { name: string; pose: Pose; trail: Trail | undefined }[];
}

const HEADING_PX = 20;

export function paintMap(sheet: Sheet, picture: MapPicture): void {
  const at = (point: Point) => toCanvas(picture.view, sheet, point);
  const { still, moving, selected, robots } = picture;
  setFont(sheet);
  for (const one of still) fill(sheet, one, at);
  for (const { trail } of robots) if (trail) paintTrail(sheet, trail, at);
  for (const one of moving) fill(sheet, one, at);
  const chosen = [...still, ...moving].filter(({ body }) => body === selected);
  for (const one of chosen) surround(sheet, one.outline, at);
  for (const one of chosen) fill(sheet, one, at);
  for (const { pose } of robots) paintHeading(sheet, pose, at);
  if (selected !== null) paintName(sheet, selected, chosen, at);
  paintBar(sheet, picture.view.scale);
}

type At = (point: Point) => [number, number];

const css = ({ r, g, b, a }: Rgba) =>
  `rgb(${Math.round(r * 255)} ${Math.round(g * 255)} ${Math.round(b * 255)} / ${a})`;

function trace(pen: Pen, outline: readonly Point[], at: At): void {
  pen.beginPath();
  for (const point of outline) pen.lineTo(...at(point));
  pen.closePath();
}

/** Thin things, such as screens, stay visible from above by a line in their own colour. */
function fill({ pen, colours }: Sheet, one: Footprint, at: At): void {
  const ground = isGround(one);
  trace(pen, one.outline, at);
  pen.fillStyle = ground ? colours.hover : css(one.color);
  pen.strokeStyle = ground ? colours.line : pen.fillStyle;
  pen.lineWidth = ground ? 1 : 2;
  pen.lineJoin = "miter";
  pen.fill();
  pen.stroke();
}

const OUTLINE_PX = 3;

function surround({ pen, colours }: Sheet, outline: readonly Point[], at: At): void {
  trace(pen, outline, at);
  pen.lineWidth = 2 * OUTLINE_PX + 2; // its inner half is covered
  pen.lineJoin = "round";
  pen.strokeStyle = colours.accent;
  pen.stroke();
}

function paintName({ pen, colours }: Sheet, name: string, chosen: readonly Footprint[], at: At): void {
  const points = chosen.flatMap(({ outline }) => outline).map(at);
  if (points.length === 0) return;
  const right = Math.max(...points.map(([x]) => x));
  const ys = points.map(([, y]) => y);
  pen.fillStyle = colours.text;
  pen.textBaseline = "middle";
  pen.fillText(name, right + 8, (Math.min(...ys) + Math.max(...ys)) / 2);
}

/** Pieces of a trail that have one opacity each; what is older is paler. */
const PIECES = 12;

function paintTrail({ pen, colours }: Sheet, { x, y }: Trail, at: At): void {
  pen.lineWidth = 2;
  pen.lineJoin = pen.lineCap = "round";
  pen.strokeStyle = colours.curves[3] ?? colours.accent;
  for (let piece = 0; piece < PIECES; piece++) {
    const from = Math.floor((piece * x.length) / PIECES);
    const to = Math.min(x.length - 1, Math.floor(((piece + 1) * x.length) / PIECES));
    pen.globalAlpha = 0.25 + (0.75 * (piece + 1)) / PIECES;
    pen.beginPath();
    for (let i = from; i <= to; i++) pen.lineTo(...at([x[i] ?? 0, y[i] ?? 0]));
    pen.stroke();
  }
  pen.globalAlpha = 1;
}

/** An arrow of constant size from the robot's origin to where it looks. */
function paintHeading({ pen, colours }: Sheet, pose: Pose, at: At): void {
  const [x, y] = at([pose.position[0], pose.position[1]]);
  pen.save();
  pen.translate(x, y);
  pen.rotate(-yawOf(pose.orientation));
  pen.beginPath();
  pen.moveTo(HEADING_PX / 2, 0);
  pen.lineTo(-HEADING_PX / 4, HEADING_PX / 4);
  pen.lineTo(-HEADING_PX / 8, 0);
  pen.lineTo(-HEADING_PX / 4, -HEADING_PX / 4);
  pen.closePath();
  pen.fillStyle = colours.text;
  pen.strokeStyle = colours.panel;
  pen.lineWidth = 1.5;
  pen.fill();
  pen.stroke();
  pen.restore();
}

const BAR_PX = 72;
/** The plate behind the bar and its length, so that both are read over walls. */
const PLATE = { high_px: 18, beyond_px: 6, opacity: 0.85 };

function paintBar({ pen, colours, height }: Sheet, scale: number): void {
  const length_m = barLength(scale, BAR_PX);
  const text = lengthText(length_m);
  const [left, right, y] = [12, 12 + length_m * scale, height - 12];
  const end = right + 6 + pen.measureText(text).width;
  pen.globalAlpha = PLATE.opacity;
  pen.fillStyle = colours.panel;
  pen.fillRect(
    left - PLATE.beyond_px,
    y - PLATE.high_px / 2,
    end - left + 2 * PLATE.beyond_px,
    PLATE.high_px,
  );
  pen.globalAlpha = 1;
  pen.strokeStyle = colours.text2;
  pen.lineWidth = 1;
  pen.beginPath();
  for (const x of [left, right]) {
    pen.moveTo(x, y - 3);
    pen.lineTo(x, y + 3);
  }
  pen.moveTo(left, y);
  pen.lineTo(right, y);
  pen.stroke();
  pen.fillStyle = colours.text2;
  pen.textBaseline = "middle";
  pen.fillText(text, right + 6, y);
}
