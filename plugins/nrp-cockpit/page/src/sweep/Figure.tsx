import { useEffect, useState } from "react";
import { Empty, Panel } from "../ui/Panel";
import { Segmented } from "../ui/Segmented";
import { CallError, wire } from "../wire";
import type { FigureKind, Sweep } from "./store";

const names: Record<FigureKind, string> = { curve: "Curve", heat: "Heat map", parallel: "Parallel" };

/** The figure of `nrp sweep --plot`, drawn by the server. */
export function Figure({ sweep }: { sweep: Sweep }) {
  const { kinds, measures, in_table } = sweep;
  const [chosen, choose] = useState<string | null>(null);
  const [wanted, want] = useState<FigureKind | null>(null);
  const kind = wanted ?? kinds[0] ?? null;
  const measure = chosen !== null && measures.includes(chosen) ? chosen : (measures[0] ?? null);
  const tools = measure !== null && (
    <>
      <select
        className="input sweep-measure"
        aria-label="Measure"
        value={measure}
        onChange={(event) => choose(event.target.value)}
      >
        {measures.map((name) => (
          <option key={name}>{name}</option>
        ))}
      </select>
      {kinds.length > 1 && (
        <Segmented
          label="Kind of figure"
          choices={kinds.map((value) => ({ value, label: names[value] }))}
          value={kind ?? "curve"}
          onChange={want}
        />
      )}
    </>
  );
  return (
    <Panel title="Figure" tools={tools} className="sweep-figure">
      {measure === null || kinds.length === 0 ? (
        <Empty>{measure === null ? "No run has been measured yet." : "Only the seed varies."}</Empty>
      ) : (
        <Drawing key={`${measure} ${kind}`} measure={measure} kind={kind} version={in_table} />
      )}
    </Panel>
  );
}

interface DrawingProps {
  measure: string;
  kind: FigureKind | null;
  /** Changes with the table. */
  version: number;
}

function Drawing({ measure, kind, version }: DrawingProps) {
  const [address, setAddress] = useState<string | null>(null);
  const [refused, setRefused] = useState<string | null>(null);
  // biome-ignore lint/correctness/useExhaustiveDependencies: a longer table is another figure
  useEffect(() => {
    let made: string | null = null;
    let isGone = false;
    wire.call<{ svg: string }>("/cockpit/sweep/figure", { measure, kind }).then(
      ({ svg }) => {
        if (isGone) return;
        made = URL.createObjectURL(new Blob([svg], { type: "image/svg+xml" }));
        setAddress(made);
      },
      (error: unknown) => setRefused(error instanceof CallError ? error.message : String(error)),
    );
    return () => {
      isGone = true;
      if (made) URL.revokeObjectURL(made);
    };
  }, [measure, kind, version]);
  if (refused !== null) return <Empty>{refused}</Empty>;
  return address && <img src={address} alt={`${measure} against what varies`} />;
}
