import { useEffect } from "react";
import { type Comparison, useComparison } from "../difference/comparison";
import { verdictOf } from "../difference/words";
import { pictureItems } from "../saving/items";
import { forgetFirstView } from "../scene/choices";
import { part } from "../state/commands";
import { useBlocked } from "../state/run";
import { Timeline } from "../timeline/Timeline";
import { Button } from "../ui/Button";
import { Menu } from "../ui/Menu";
import { Begin } from "./Begin";
import { DistancePlot } from "./DistancePlot";
import { embeddedAddress } from "./embedded";
import { Tables } from "./Tables";
import "./compare.css";

/** Two runs beside each other, in step, and how they differ. */
export default function CompareView() {
  const comparison = useComparison((state) => state.comparison);
  return (
    <div className="compare">
      <h1 className="hidden-text">Compare</h1>
      {comparison ? <Two comparison={comparison} /> : <Begin />}
      <div className="cockpit-timeline" data-panel="timeline" tabIndex={-1}>
        <Timeline />
      </div>
    </div>
  );
}

function plotItems() {
  const plot = document.querySelector<HTMLElement>(".distance");
  return plot ? pictureItems(plot, () => "distance") : [];
}

function Two({ comparison }: { comparison: Comparison }) {
  const blocked = useBlocked();
  useEffect(forgetFirstView, []); // before the frames have loaded
  const [one, other] = comparison.labels;
  return (
    <>
      <div className="compare-runs">
        <Shown label={one} run="" />
        <Shown label={other} run="beside" />
      </div>
      <section className="panel compare-difference" aria-label="Difference">
        <div className="panel-head">
          <h2>Difference</h2>
          <span className="panel-sub cut" role="status">
            {verdictOf(comparison)}
          </span>
          <span className="grow" />
          <Menu label="Save the plot" items={plotItems} className="btn btn-small btn-ghost">
            Save
          </Menu>
          <Button small kind="ghost" icon="close" disabled={blocked} onClick={() => void part()}>
            Close the second run
          </Button>
        </div>
        <div className="panel-body">
          <DistancePlot comparison={comparison} />
          <Tables comparison={comparison} />
        </div>
      </section>
    </>
  );
}

/** One of the runs, in a frame that hears only that run. */
function Shown({ label, run }: { label: string; run: string }) {
  return (
    <figure className="compare-run" data-second={run !== "" || undefined}>
      <figcaption>{label}</figcaption>
      <iframe title={label} src={embeddedAddress(window.location, run)} />
    </figure>
  );
}
