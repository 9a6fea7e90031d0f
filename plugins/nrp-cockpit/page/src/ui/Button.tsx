import type { ButtonHTMLAttributes, MouseEvent, ReactNode } from "react";
import { notify } from "../state/notices";
import { Icon, type IconName } from "./Icon";
import { Tooltip } from "./Tooltip";

type Native = Omit<ButtonHTMLAttributes<HTMLButtonElement>, "disabled" | "title" | "onClick">;

export interface ButtonProps extends Native {
  kind?: "plain" | "primary" | "ghost";
  small?: boolean;
  icon?: IconName;
  /** True while the answer is awaited; the width stays. */
  busy?: boolean;
  /** Why the button cannot be used now; it stays reachable by keyboard, so that the reason can be read. */
  disabled?: string | false | undefined;
  tip?: string | undefined;
  onClick?: (event: MouseEvent<HTMLButtonElement>) => void;
  children?: ReactNode;
}

const classOf = (kind: string, small: boolean, icon: boolean, more = "") =>
  ["btn", kind !== "plain" && `btn-${kind}`, small && "btn-small", icon && "btn-icon", more]
    .filter(Boolean)
    .join(" ");

/** A button with words; `disabled` is the reason, shown as its tip, and by a click that comes too early. */
export function Button(props: ButtonProps) {
  const {
    kind = "plain",
    small = false,
    icon,
    busy = false,
    disabled,
    tip,
    onClick,
    children,
    ...rest
  } = props;
  const { className, ...native } = rest;
  const click = (event: MouseEvent<HTMLButtonElement>) => {
    if (!disabled && !busy) return onClick?.(event);
    event.preventDefault();
    if (disabled) notify(disabled);
  };
  return (
    <Tooltip text={disabled || tip}>
      <button
        type="button"
        {...native}
        className={classOf(kind, small, children === undefined, className)}
        aria-disabled={disabled ? true : undefined}
        aria-busy={busy || undefined}
        onClick={click}
      >
        {icon && <Icon name={icon} />}
        {children}
      </button>
    </Tooltip>
  );
}

export interface IconButtonProps extends Omit<ButtonProps, "children" | "icon"> {
  icon: IconName;
  /** The accessible name, also shown as the tip. */
  label: string;
  /** The key that does the same, shown behind the name. */
  shortcut?: string;
}

/** A button of one icon; its label is its accessible name and its tip. */
export function IconButton({ label, shortcut, tip, ...rest }: IconButtonProps) {
  const named = shortcut ? `${label} (${shortcut})` : label;
  return <Button {...rest} aria-label={label} aria-keyshortcuts={shortcut} tip={tip ?? named} />;
}
