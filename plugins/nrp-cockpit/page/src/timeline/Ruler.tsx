import { type KeyboardEventHandler, useEffect, useRef, useState } from "react";
import { useRun } from "../state/run";
import { percent, type Span, ticks } from "./scale";

const LABEL_PX = 72;

interface RulerProps {
  span: Span;
  end_s: number;
  onKeyDown: KeyboardEventHandler;
}

/** The scale of the time, and the slider of the current time to the keyboard and to a screen reader. */
export function Ruler({ span, end_s, onKeyDown }: RulerProps) {
  const ruler = useRef<HTMLDivElement>(null);
  const [width, setWidth] = useState(LABEL_PX);
  const t_s = useRun((run) => run.status?.t_s ?? 0);
  useEffect(() => {
    const element = ruler.current;
    if (!element) return;
    const sized = new ResizeObserver(() => setWidth(element.clientWidth));
    sized.observe(element);
    return () => sized.disconnect();
  }, []);
  return (
    <div
      ref={ruler}
      className="timeline-ruler num"
      role="slider"
      tabIndex={0}
      aria-label="Simulated time"
      aria-valuemin={0}
      aria-valuemax={end_s}
      aria-valuenow={t_s}
      aria-valuetext={`${t_s.toFixed(2)} seconds`}
      onKeyDown={onKeyDown}
    >
      {ticks(span, width / LABEL_PX).map((tick) => {
        const at = percent(span, tick);
        return (
          <span
            key={tick}
            style={{ left: `${at}%` }}
            data-edge={at < 1 ? "left" : at > 99 ? "right" : undefined}
          >
            {tick}
          </span>
        );
      })}
    </div>
  );
}
