import { useState } from "react";
import { Slider } from "../parameters/Slider";
import { baseName } from "../state/paths";
import { useBlocked } from "../state/run";
import type { Literal } from "./literal";
import { isLive, setNumber, useFunctions } from "./store";

/** A slider for the number at the cursor: the run has it at once, unless other edits wait for Apply. */
export function LiteralSlider({ path }: { path: string }) {
  const literal = useFunctions((state) => state.literal);
  return literal && <Held key={`${path} ${literal.from}`} path={path} literal={literal} />;
}

/** Its ends stay while it moves. */
function Held({ path, literal: { line, value, whole } }: { path: string; literal: Literal }) {
  const blocked = useBlocked();
  const live = useFunctions(isLive);
  const [{ low, high }] = useState(() => {
    const half = Math.abs(value) || 1;
    return { low: value - half, high: value + half };
  });
  const number = { name: `line ${line}`, value, low, high, whole, note: live ? "" : "waits for Apply" };
  return (
    <ul className="literal" aria-label="Number at the cursor">
      <Slider
        number={number}
        of={baseName(path)}
        disabled={blocked !== undefined}
        onChange={(next) => setNumber(path, next)}
      />
    </ul>
  );
}
