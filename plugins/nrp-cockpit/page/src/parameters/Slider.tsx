import { type CSSProperties, useEffect, useRef, useState } from "react";
import { type ChangeableNumber, LatestOnly, shortened, stepOf } from "./numbers";

interface SliderProps {
  number: ChangeableNumber;
  /** Of what it is a number. */
  of: string;
  disabled: boolean;
  onChange: (value: number) => Promise<unknown>;
}

/** Between two values of a slider that moves: each change of the run takes a snapshot. */
const REST_MS = 100;

/** A number with a slider, and a field for values that the slider does not reach. */
export function Slider({ number, of, disabled, onChange }: SliderProps) {
  const { name, value, low, high, note } = number;
  const [shown, setShown] = useState(value);
  const latest = useRef(new LatestOnly(REST_MS));
  useEffect(() => setShown(value), [value]);
  const change = (text: string) => {
    const next = Number(text);
    if (text === "" || !Number.isFinite(next) || next === shown) return;
    setShown(next);
    void latest.current.ask(() => onChange(next));
  };
  const step = stepOf(number);
  const at = Math.min(Math.max(((shown ?? low) - low) / (high - low), 0), 1);
  return (
    <li className="parameter">
      <span className="mono cut" title={note || name}>
        {name}
      </span>
      <input
        type="range"
        aria-label={`${name} of ${of}`}
        aria-valuetext={shown === null ? "different values" : `${shortened(shown)} ${note}`}
        min={low}
        max={high}
        step={step}
        value={shown ?? (low + high) / 2}
        disabled={disabled}
        style={{ "--v": `${at * 100}%` } as CSSProperties}
        onChange={(event) => change(String(shortened(Number(event.target.value))))}
      />
      <input
        key={shown}
        className="input num"
        inputMode="decimal"
        aria-label={`Value of ${name} of ${of}`}
        placeholder="varies"
        defaultValue={shown === null ? "" : shortened(shown)}
        disabled={disabled}
        onKeyDown={({ key, currentTarget }) => key === "Enter" && change(currentTarget.value)}
        onBlur={(event) => change(event.target.value)}
      />
      <span className="dim f11 cut" title={note}>
        {note}
      </span>
    </li>
  );
}
