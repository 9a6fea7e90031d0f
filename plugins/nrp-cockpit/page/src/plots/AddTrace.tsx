import { type KeyboardEvent, useEffect, useId, useMemo, useRef, useState } from "react";
import { createPortal } from "react-dom";
import { useRun } from "../state/run";
import { addTrace, type Trace } from "../state/traces";
import { Button } from "../ui/Button";
import { wire } from "../wire";
import { offeredTraces } from "./offered";
import { keyOf } from "./traceStore";

const LISTED = 200;
const WIDTH = 360;

/** A button that opens the list of all numbers of all topics, to be searched by words. */
export function AddTrace() {
  const [at, setAt] = useState<DOMRect | null>(null);
  const place = useRef<HTMLSpanElement>(null);
  const close = () => {
    setAt(null);
    place.current?.querySelector("button")?.focus();
  };
  return (
    <span ref={place}>
      <Button
        icon="plus"
        kind="ghost"
        small
        aria-haspopup="dialog"
        aria-expanded={at !== null}
        onClick={(event) => setAt(at ? null : event.currentTarget.getBoundingClientRect())}
      >
        Add
      </Button>
      {at && createPortal(<Chooser at={at} onClose={close} />, document.body)}
    </span>
  );
}

function Chooser({ at, onClose }: { at: DOMRect; onClose: () => void }) {
  const devices = useRun((run) => run.experiment?.devices);
  const all = useMemo(() => offeredTraces(wire.offered(), devices ?? []), [devices]);
  const [text, setText] = useState("");
  const words = text.toLowerCase().split(/\s+/);
  const found = all.filter((trace) => words.every((word) => keyOf(trace).toLowerCase().includes(word)));
  const box = useRef<HTMLDivElement>(null);
  const title = useId();
  useEffect(() => box.current?.querySelector("input")?.focus(), []);
  const choose = (trace: Trace) => {
    addTrace(trace);
    onClose();
  };
  const key = (event: KeyboardEvent<HTMLElement>) => {
    const fields = [...event.currentTarget.querySelectorAll<HTMLElement>("input, button")];
    const now = fields.indexOf(document.activeElement as HTMLElement);
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (step !== undefined) fields[(now + step + fields.length) % fields.length]?.focus();
    else if (event.key === "Escape") onClose();
    else if (event.key === "Enter" && now === 0 && found[0]) choose(found[0]);
    else return;
    event.preventDefault();
    event.stopPropagation();
  };
  const left = Math.max(8, Math.min(at.left, window.innerWidth - WIDTH - 8));
  const below = at.bottom + 4 + 320 < window.innerHeight;
  const vertical = below ? { top: at.bottom + 4 } : { bottom: window.innerHeight - at.top + 4 };
  return (
    <>
      <div className="menu-back" aria-hidden="true" onPointerDown={onClose} />
      <div
        ref={box}
        className="menu-list trace-chooser"
        role="dialog"
        aria-labelledby={title}
        style={{ left, width: WIDTH, ...vertical }}
        onKeyDown={key}
      >
        <h3 id={title} className="hidden-text">
          Add a curve
        </h3>
        <input
          className="input"
          type="search"
          aria-label="Search the topics"
          placeholder="Search topics and fields"
          value={text}
          onChange={(event) => setText(event.target.value)}
        />
        <ul className="scroll">
          {found.slice(0, LISTED).map((trace) => (
            <li key={keyOf(trace)}>
              <button type="button" onClick={() => choose(trace)}>
                <span className="cut mut">{trace.topic}</span>
                <b className="mono">{trace.path}</b>
              </button>
            </li>
          ))}
        </ul>
        {found.length === 0 && <p className="trace-none">No number has these words.</p>}
        {found.length > LISTED && (
          <p className="trace-none">{found.length - LISTED} more: search for words.</p>
        )}
      </div>
    </>
  );
}
