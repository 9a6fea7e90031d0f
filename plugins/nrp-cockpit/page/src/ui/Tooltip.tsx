import {
  cloneElement,
  type ReactElement,
  type SyntheticEvent,
  useEffect,
  useId,
  useRef,
  useState,
} from "react";
import { createPortal } from "react-dom";

type Handler = (event: SyntheticEvent<HTMLElement>) => void;
type Target = ReactElement<{
  "aria-describedby"?: string | undefined;
  onPointerEnter?: Handler;
  onPointerLeave?: Handler;
  onPointerDown?: Handler;
  onFocus?: Handler;
  onBlur?: Handler;
}>;

const DELAY_MS = 400;

/** Shows a sentence beside its one child after a short rest of the pointer, and at once on keyboard focus. */
export function Tooltip({ text, children }: { text: string | false | undefined; children: Target }) {
  const [at, setAt] = useState<DOMRect | null>(null);
  const timer = useRef(0);
  const id = useId();
  useEffect(() => () => window.clearTimeout(timer.current), []);
  if (!text) return children;
  const hide = () => {
    window.clearTimeout(timer.current);
    setAt(null);
  };
  const show = (event: SyntheticEvent<HTMLElement>, delay: number) => {
    const target = event.currentTarget;
    timer.current = window.setTimeout(() => setAt(target.getBoundingClientRect()), delay);
  };
  const focus = (event: SyntheticEvent<HTMLElement>) => {
    if (event.currentTarget.matches(":focus-visible")) show(event, 0);
  };
  return (
    <>
      {cloneElement(children, {
        "aria-describedby": at ? id : undefined,
        onPointerEnter: (event) => show(event, DELAY_MS),
        onPointerLeave: hide,
        onPointerDown: hide,
        onFocus: focus,
        onBlur: hide,
      })}
      {at && createPortal(<Tip id={id} text={text} at={at} />, document.body)}
    </>
  );
}

function Tip({ id, text, at }: { id: string; text: string; at: DOMRect }) {
  const below = at.bottom + 40 < window.innerHeight;
  const left = Math.min(Math.max(8, at.left), window.innerWidth - Math.min(320, text.length * 7 + 24));
  const place = below ? { top: at.bottom + 6 } : { bottom: window.innerHeight - at.top + 6 };
  return (
    <div id={id} role="tooltip" className="tip" style={{ left, ...place }}>
      {text}
    </div>
  );
}
