import { notify } from "../state/notices";
import { Tooltip } from "./Tooltip";

interface SwitchProps {
  label: string;
  on: boolean;
  onChange: (on: boolean) => void;
  /** Why it cannot be switched now. */
  disabled?: string | undefined;
}

/** On or off, at once. */
export function Switch({ label, on, onChange, disabled }: SwitchProps) {
  return (
    <Tooltip text={disabled}>
      <button
        type="button"
        role="switch"
        className="switch"
        aria-label={label}
        aria-checked={on}
        aria-disabled={disabled ? true : undefined}
        onClick={() => (disabled ? notify(disabled) : onChange(!on))}
      />
    </Tooltip>
  );
}
