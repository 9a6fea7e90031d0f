import { useEffect, useMemo, useState } from "react";
import { keep, kept } from "../state/kept";
import { useRun } from "../state/run";
import { useSelection } from "../state/selection";
import { useView } from "../state/view";
import { Icon } from "../ui/Icon";
import { followed, hints, nextHint, type Seen } from "./hints";
import "./hints.css";

const KEPT = "nrp-cockpit-hints";

const doneBefore = (): ReadonlySet<string> => new Set((kept(KEPT) ?? "").split(" ").filter(Boolean));

/** Tells a new person what to do first, one thing at a time; what was done or skipped is not told again. */
export function FirstVisit() {
  const [done, setDone] = useState(doneBefore);
  const seen = useSeen();
  useEffect(() => {
    if (seen) setDone((before) => followed(before, seen));
  }, [seen]);
  useEffect(() => {
    if (done.size > 0) keep(KEPT, [...done].join(" "));
  }, [done]);
  const next = nextHint(done);
  if (!seen || !next) return null;
  return (
    <span className="hint" role="status">
      <Icon name="note" small />
      {next.hint.text(seen)}
      <span className="dim num">
        {next.number} of {hints.length}
      </span>
      <button type="button" onClick={() => setDone(new Set(hints.map(({ id }) => id)))}>
        Skip
      </button>
    </span>
  );
}

/** What the hints look at; null for somebody who cannot follow them, as of a recording or without steering. */
function useSeen(): Seen | null {
  const experiment = useRun((run) => run.experiment);
  const state = useRun((run) => run.status?.state);
  const selected = useSelection((chosen) => chosen.selected?.kind);
  const view = useView((shown) => shown.view);
  return useMemo(() => {
    const follows = experiment?.may_steer && experiment.source === "live" && state !== undefined;
    return follows ? { experiment, status: { state }, selected, view } : null;
  }, [experiment, state, selected, view]);
}
