import type { KeyboardEvent } from "react";

interface Choice<T extends string> {
  value: T;
  label: string;
}

interface SegmentedProps<T extends string> {
  /** The accessible name of the group. */
  label: string;
  choices: readonly Choice<T>[];
  value: T;
  onChange: (value: T) => void;
}

/** One of a few: radio buttons in a row; arrows move the choice. */
export function Segmented<T extends string>({ label, choices, value, onChange }: SegmentedProps<T>) {
  const move = (event: KeyboardEvent<HTMLElement>) => {
    const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
    if (step === undefined) return;
    event.preventDefault();
    const at = choices.findIndex((choice) => choice.value === value);
    const next = choices[(at + step + choices.length) % choices.length];
    if (next) onChange(next.value);
    const buttons = event.currentTarget.querySelectorAll("button");
    buttons[(at + step + choices.length) % choices.length]?.focus();
  };
  return (
    <div className="seg" role="radiogroup" aria-label={label} onKeyDown={move}>
      {choices.map((choice) => (
        // biome-ignore lint/a11y/useSemanticElements: a native radio cannot be drawn as a segment
        <button
          key={choice.value}
          type="button"
          role="radio"
          aria-checked={choice.value === value}
          tabIndex={choice.value === value ? 0 : -1}
          onClick={() => onChange(choice.value)}
        >
          {choice.label}
        </button>
      ))}
    </div>
  );
}

interface TogglesProps<T extends string> {
  label: string;
  choices: readonly Choice<T>[];
  on: ReadonlySet<T>;
  onToggle: (value: T) => void;
}

/** Any of a few: toggle buttons in a row. */
export function Toggles<T extends string>({ label, choices, on, onToggle }: TogglesProps<T>) {
  return (
    <fieldset className="seg" aria-label={label}>
      {choices.map(({ value, label: name }) => (
        <button key={value} type="button" aria-pressed={on.has(value)} onClick={() => onToggle(value)}>
          {name}
        </button>
      ))}
    </fieldset>
  );
}
