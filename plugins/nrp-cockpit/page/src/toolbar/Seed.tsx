import { useState } from "react";
import { command } from "../state/commands";
import { useBlocked, useRun } from "../state/run";
import { Button } from "../ui/Button";

/** The seed of the run; another one is for a run that begins again. */
export function Seed() {
  const seed = useRun((run) => run.experiment?.seed);
  const live = useRun((run) => run.experiment?.source === "live");
  if (seed === undefined) return null;
  if (!live)
    return (
      <span className="row tight f12 mut">
        Seed <b className="num">{seed}</b>
      </span>
    );
  return <SeedField key={seed} seed={seed} />;
}

function SeedField({ seed }: { seed: number }) {
  const [text, setText] = useState(String(seed));
  const blocked = useBlocked();
  const wanted = /^\d+$/.test(text) ? Number(text) : null;
  const isOther = wanted !== null && wanted !== seed;
  return (
    <form
      className="row tight f12 mut"
      onSubmit={(event) => {
        event.preventDefault();
        if (isOther && !blocked) void command("reseed", { seed: wanted });
      }}
    >
      <label className="row tight">
        Seed
        <input
          className="bar-seed input num"
          inputMode="numeric"
          value={text}
          disabled={blocked !== undefined}
          aria-invalid={wanted === null || undefined}
          onChange={(event) => setText(event.target.value)}
        />
      </label>
      {isOther && (
        <Button small type="submit" disabled={blocked}>
          Begin again
        </Button>
      )}
    </form>
  );
}
