import { type KeyboardEvent, type ReactNode, useEffect, useId, useRef, useState } from "react";
import { createPortal } from "react-dom";
import { Button } from "./Button";
import { movesFocus, usePopup } from "./popup";

interface ChooserProps<T> {
  /** What the button says. */
  children: ReactNode;
  icon?: "plus";
  kind?: "ghost";
  small?: boolean;
  /** The accessible names of the list and of its search. */
  title: string;
  search: string;
  /** Asked when the list opens. */
  choices: () => readonly T[];
  /** The text of a choice: its key, and what words are searched in. */
  textOf: (choice: T) => string;
  /** What is shown of a choice; by default its text. */
  show?: (choice: T) => ReactNode;
  none: string;
  onChoose: (choice: T) => void;
}

/** A button that opens a list to be searched by words; arrows move, Enter chooses, Escape closes. */
export function Chooser<T>({ children, icon, kind, small, ...list }: ChooserProps<T>) {
  const { at, place, toggle, close } = usePopup();
  return (
    <span ref={place}>
      <Button
        {...(icon ? { icon } : {})}
        {...(kind ? { kind } : {})}
        {...(small ? { small } : {})}
        aria-haspopup="dialog"
        aria-expanded={at !== null}
        onClick={toggle}
      >
        {children}
      </Button>
      {at && createPortal(<Choices {...list} at={at} onClose={close} />, document.body)}
    </span>
  );
}

const LISTED = 200;
const WIDTH = 360;
const HIGHEST = 320;

interface ChoicesProps<T> extends Omit<ChooserProps<T>, "children"> {
  at: DOMRect;
  onClose: () => void;
}

function Choices<T>({ at, onClose, title, search, choices, textOf, show, none, onChoose }: ChoicesProps<T>) {
  const [text, setText] = useState("");
  const words = text.toLowerCase().split(/\s+/);
  const [all] = useState(choices);
  const found = all.filter((one) => words.every((word) => textOf(one).toLowerCase().includes(word)));
  const box = useRef<HTMLDivElement>(null);
  const heading = useId();
  useEffect(() => box.current?.querySelector("input")?.focus(), []);
  const choose = (choice: T) => {
    onClose();
    onChoose(choice);
  };
  const key = (event: KeyboardEvent<HTMLElement>) => {
    const [first] = found;
    const searching = document.activeElement instanceof HTMLInputElement;
    if (event.key === "Escape") onClose();
    else if (event.key === "Enter" && searching && first !== undefined) choose(first);
    else if (!movesFocus(event, "input, button")) return;
    event.preventDefault();
    event.stopPropagation();
  };
  const left = Math.max(8, Math.min(at.left, window.innerWidth - WIDTH - 8));
  const below = at.bottom + 4 + HIGHEST < window.innerHeight;
  const vertical = below ? { top: at.bottom + 4 } : { bottom: window.innerHeight - at.top + 4 };
  return (
    <>
      <div className="menu-back" aria-hidden="true" onPointerDown={onClose} />
      <div
        ref={box}
        className="menu-list chooser"
        role="dialog"
        aria-labelledby={heading}
        style={{ left, width: WIDTH, ...vertical }}
        onKeyDown={key}
      >
        <h3 id={heading} className="hidden-text">
          {title}
        </h3>
        <input
          className="input"
          type="search"
          aria-label={search}
          placeholder={search}
          value={text}
          onChange={(event) => setText(event.target.value)}
        />
        <ul className="scroll">
          {found.slice(0, LISTED).map((choice) => (
            <li key={textOf(choice)}>
              <button type="button" onClick={() => choose(choice)}>
                {show ? show(choice) : <span className="mono">{textOf(choice)}</span>}
              </button>
            </li>
          ))}
        </ul>
        {found.length === 0 && <p className="chooser-none">{none}</p>}
        {found.length > LISTED && (
          <p className="chooser-none">{found.length - LISTED} more: search for words.</p>
        )}
      </div>
    </>
  );
}
