import { useRef } from "react";
import { type Run, useRun } from "../state/run";
import { removeTrace } from "../state/traces";
import { Icon } from "../ui/Icon";
import { READABLE_MS } from "../ui/rarely";
import { useRarely } from "../ui/useRarely";
import { clock } from "./clock";
import { valueAt } from "./curve";
import type { Group, Shown } from "./groups";
import { PlotTable, type Row } from "./PlotTable";
import { CURVE_COLOURS } from "./palette";
import { drawCursors, drawEvents, drawTimeAxis, MARGIN, setFont } from "./pen";
import { CURVE_COLUMNS, curveRow } from "./tables";
import { type TimeScale, timeAt, valueText } from "./timeAxis";
import { heardOf, keyOf, valuesOf } from "./traceStore";
import { paintCurves, TOP } from "./tracesPicture";
import { useCanvas } from "./useCanvas";
import { useMarks } from "./useMarks";
import { crosshair, scaleNow, useTimeNavigation } from "./useTimeNavigation";

interface GroupProps {
  group: Group;
  /** Whether the time is written below. */
  last: boolean;
}

/** The curves of one axis, with a legend that says their values at the pointer, or now. */
export function TraceGroup({ group: { title, curves }, last }: GroupProps) {
  const marks = useMarks();
  const scale = useRef<TimeScale>({ from_s: 0, to_s: 1, left: 0, right: 1 });
  const height = useRef(0);
  const values = useRef(new Map<string, HTMLElement>());
  const off = useRun(offDevices).split(" ");
  const saying = useRarely(READABLE_MS, () =>
    sayValues(scale.current, height.current, curves, values.current, off),
  );
  const { ref, redraw } = useCanvas((sheet) => {
    const bottom = sheet.height - (last ? MARGIN.bottom : TOP);
    scale.current = scaleNow(MARGIN.left, sheet.width - MARGIN.right);
    if (bottom - TOP < 8 || scale.current.right - scale.current.left < 8) return;
    setFont(sheet);
    drawTimeAxis(sheet, scale.current, TOP, bottom, last);
    height.current = paintCurves(sheet, scale.current, curves, bottom);
    drawEvents(sheet, scale.current, marks, { top: TOP, bottom });
    drawCursors(sheet, scale.current, clock.now_s, TOP, bottom);
    saying.ask();
  });
  const handlers = useTimeNavigation(ref, scale, redraw);
  const keep = (key: string) => (element: HTMLElement | null) => {
    if (element) values.current.set(key, element);
    else values.current.delete(key);
  };
  const names = curves.map(({ label }) => label).join(", ");
  return (
    <section className="trace-group" aria-label={title}>
      <div className="trace-head">
        <h3 className="cut" title={title}>
          {title}
        </h3>
        <ul>
          {curves.map((shown) => (
            <Entry key={keyOf(shown.trace)} shown={shown} value={keep(keyOf(shown.trace))} />
          ))}
        </ul>
      </div>
      <canvas
        ref={ref}
        className="plot-canvas"
        role="img"
        aria-label={`Curves of ${names}`}
        data-y={title}
        {...handlers}
      />
      <PlotTable caption={`Curves of ${names}`} columns={CURVE_COLUMNS} rows={() => curves.map(rowNow)} />
    </section>
  );
}

function rowNow({ trace, label }: Shown): Row {
  const { from_s, to_s } = scaleNow(0, 1);
  return curveRow(label, valuesOf(trace), from_s, Math.min(to_s, clock.now_s));
}

/** How many last letters of a name stay in view: names often differ there. */
const TAIL = 6;

function Entry({ shown, value }: { shown: Shown; value: (element: HTMLElement | null) => void }) {
  const { trace, label, colour } = shown;
  return (
    <li className="key trace-key">
      <i style={{ "--c": `var(${CURVE_COLOURS[colour]})` } as React.CSSProperties} />
      <span className="trace-name" title={label}>
        <span className="cut">{label.slice(0, -TAIL)}</span>
        <span>{label.slice(-TAIL)}</span>
      </span>
      <b ref={value} />
      <button type="button" aria-label={`Remove ${label}`} onClick={() => removeTrace(trace)}>
        <Icon name="close" small />
      </button>
    </li>
  );
}

/** The topics of the devices of functions that do not run: their values stand for nothing. */
function offDevices({ experiment, functions }: Run): string {
  const idle = functions?.functions.filter(({ active }) => !active).map(({ name }) => `${name}/`) ?? [];
  const devices = idle.length > 0 ? (experiment?.devices ?? []) : [];
  return devices
    .filter(({ name }) => idle.some((one) => name.startsWith(one)))
    .map(({ topic }) => topic)
    .join(" ");
}

function sayValues(
  scale: TimeScale,
  height: number,
  curves: readonly Shown[],
  values: Map<string, HTMLElement>,
  off: readonly string[],
): void {
  const pointed_s =
    crosshair.share === null
      ? Math.min(scale.to_s, clock.now_s)
      : timeAt(scale, scale.left + crosshair.share * (scale.right - scale.left));
  for (const { trace } of curves) {
    const value = heardOf(trace).has(pointed_s) ? valueAt(valuesOf(trace), pointed_s) : undefined;
    const isOff = crosshair.share === null && off.includes(trace.topic);
    const text = isOff ? "off" : valueText(value, height);
    const element = values.get(keyOf(trace));
    if (element && element.textContent !== text) element.textContent = text;
  }
}
