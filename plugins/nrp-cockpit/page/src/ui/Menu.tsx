import { type KeyboardEvent, type ReactNode, useEffect, useRef } from "react";
import { createPortal } from "react-dom";
import { notify } from "../state/notices";
import { Icon, type IconName } from "./Icon";
import { movesFocus, usePopup } from "./popup";
import { Tooltip } from "./Tooltip";

export interface MenuItem {
  label: string;
  icon?: IconName;
  shortcut?: string;
  /** Why it cannot be chosen now. */
  disabled?: string | undefined;
  onSelect: () => void;
}

interface MenuProps {
  label: string;
  /** As a function they are asked for when the menu opens. */
  items: readonly MenuItem[] | (() => readonly MenuItem[]);
  /** What the button shows. */
  children: ReactNode;
  className?: string;
  /** Why the menu cannot be opened now; the button stays reachable by keyboard, so that the reason can be read. */
  disabled?: string | undefined;
  /** The name by which the map of keys presses the button. */
  "data-key"?: string;
}

/** A button that opens a list of actions; arrows move, Enter chooses, Escape closes. */
export function Menu({ label, items, children, className = "btn", disabled, "data-key": key }: MenuProps) {
  const { at, place, toggle, close } = usePopup();
  return (
    <span ref={place} className="menu">
      <Tooltip text={disabled ?? label}>
        <button
          type="button"
          className={className}
          data-key={key}
          aria-label={label}
          aria-haspopup="menu"
          aria-expanded={at !== null}
          aria-disabled={disabled ? true : undefined}
          onClick={(event) => (disabled ? notify(disabled) : toggle(event))}
        >
          {children}
        </button>
      </Tooltip>
      {at &&
        !disabled &&
        createPortal(
          <MenuList
            label={label}
            items={typeof items === "function" ? items() : items}
            at={at}
            onClose={close}
          />,
          document.body,
        )}
    </span>
  );
}

interface ListProps {
  label: string;
  items: readonly MenuItem[];
  at: DOMRect;
  onClose: () => void;
}

function MenuList({ label, items, at, onClose }: ListProps) {
  const list = useRef<HTMLDivElement>(null);
  useEffect(() => {
    list.current?.querySelector("button")?.focus();
  }, []);
  const key = (event: KeyboardEvent<HTMLElement>) => {
    if (event.key === "Escape" || event.key === "Tab") onClose();
    else if (!movesFocus(event, "button")) return;
    event.preventDefault();
    event.stopPropagation();
  };
  const right = at.left + 224 > window.innerWidth;
  const left = right ? at.right - 216 : at.left;
  const height = items.length * 32 + 8;
  const top = at.bottom + 4 + height > window.innerHeight ? at.top - 4 - height : at.bottom + 4;
  return (
    <>
      <div className="menu-back" aria-hidden="true" onPointerDown={onClose} />
      <div
        ref={list}
        className="menu-list"
        role="menu"
        aria-label={label}
        style={{ left, top }}
        onKeyDown={key}
      >
        {items.map((item) => (
          <Entry key={item.label} item={item} onClose={onClose} />
        ))}
      </div>
    </>
  );
}

function Entry({ item, onClose }: { item: MenuItem; onClose: () => void }) {
  const choose = () => {
    if (item.disabled) return notify(item.disabled);
    onClose();
    item.onSelect();
  };
  return (
    <button
      type="button"
      role="menuitem"
      tabIndex={-1}
      aria-disabled={item.disabled ? true : undefined}
      title={item.disabled}
      onClick={choose}
    >
      {item.icon && <Icon name={item.icon} />}
      {item.label}
      {item.shortcut && <kbd>{item.shortcut}</kbd>}
    </button>
  );
}
