import { type KeyboardEvent, type PointerEvent, type ReactNode, useEffect, useRef, useState } from "react";
import { go } from "./go";
import { here } from "./here";
import { Ruler } from "./Ruler";
import { type Reach, reach, reachByKey, seconds } from "./reach";
import { percent, type Span, timeAt } from "./scale";

interface TrackProps {
  span: Span;
  /** Where the run ends, as far as is known. */
  end_s: number;
  onZoom: (factor: number, at_s: number) => void;
  children: ReactNode;
}

/** The ruler over the lanes. A click or a drag goes to a time; before it, the tip says what that would mean. */
export function Track({ span, end_s, onZoom, children }: TrackProps) {
  const [ghost, setGhost] = useState<Reach | null>(null);
  const track = useRef<HTMLDivElement>(null);
  const timeOf = (clientX: number) => {
    const box = track.current?.getBoundingClientRect();
    return box ? timeAt(span, (clientX - box.left) / box.width) : 0;
  };
  useWheel(track, (event) => onZoom(event.deltaY > 0 ? 1.25 : 0.8, timeOf(event.clientX)));
  const onMark = (event: PointerEvent) => (event.target as Element).closest("button") !== null;
  const move = (event: PointerEvent<HTMLDivElement>) => {
    if (onMark(event)) return setGhost(null);
    const to = reach(timeOf(event.clientX), here());
    setGhost(to);
    if (to.act === "seek" && event.buttons === 1) void go(to);
  };
  const press = (event: PointerEvent<HTMLDivElement>) => {
    if (event.button !== 0 || onMark(event)) return;
    event.currentTarget.setPointerCapture(event.pointerId);
    move(event);
  };
  const release = (event: PointerEvent<HTMLDivElement>) => {
    if (!event.currentTarget.hasPointerCapture(event.pointerId)) return;
    setGhost(null);
    void go(reach(timeOf(event.clientX), here()));
  };
  const key = (event: KeyboardEvent) => {
    const to = reachByKey(event.key, here(), end_s);
    if (!to) return;
    event.preventDefault();
    void go(to);
  };
  return (
    <div
      ref={track}
      className="timeline-track"
      onPointerMove={move}
      onPointerDown={press}
      onPointerUp={release}
      onPointerLeave={() => setGhost(null)}
    >
      <Ruler span={span} end_s={end_s} onKeyDown={key} />
      {children}
      {ghost && <Ghost to={ghost} span={span} />}
    </div>
  );
}

/** The wheel zooms; React's own handler could not keep the page from scrolling. */
function useWheel(target: React.RefObject<HTMLDivElement | null>, zoom: (event: WheelEvent) => void): void {
  const current = useRef(zoom);
  useEffect(() => {
    current.current = zoom;
  });
  useEffect(() => {
    const wheel = (event: WheelEvent) => {
      event.preventDefault();
      current.current(event);
    };
    const element = target.current;
    element?.addEventListener("wheel", wheel, { passive: false });
    return () => element?.removeEventListener("wheel", wheel);
  }, [target]);
}

function Ghost({ to, span }: { to: Reach; span: Span }) {
  const at = percent(span, to.t_s);
  return (
    <div className="timeline-ghost" data-refused={to.act === "none"} style={{ left: `${at}%` }}>
      <span className="num" data-edge={at > 70 ? "right" : "left"}>
        {to.act === "none" ? `${seconds(to.t_s)}. ${to.says}` : to.says}
      </span>
    </div>
  );
}
