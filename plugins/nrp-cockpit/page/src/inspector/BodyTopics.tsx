import { useMemo } from "react";
import { offeredTraces } from "../plots/offered";
import { useRun } from "../state/run";
import { addTrace, dragTrace, useTraces } from "../state/traces";
import type { TopicInfo } from "../state/types";
import { Icon } from "../ui/Icon";
import { wire } from "../wire";
import { Section } from "./Facts";

const NO_TOPICS: readonly TopicInfo[] = [];

/** The topics of a body, but those that only colour it. */
export function BodyTopics({ names }: { names: readonly string[] }) {
  const all = useRun((run) => run.experiment?.topics ?? NO_TOPICS);
  const topics = all.filter(({ name }) => names.includes(name) && !name.endsWith("/color"));
  if (topics.length === 0) return null;
  return (
    <Section title="Topics">
      {topics.map((topic) => (
        <Topic key={topic.name} topic={topic} />
      ))}
    </Section>
  );
}

const shortType = (type: string) => type.split("/").at(-1) ?? type;

function Topic({ topic: { name, type, direction, unit, rate_hz } }: { topic: TopicInfo }) {
  const about = [
    shortType(type),
    direction === "in" ? "heard by the run" : null,
    unit,
    rate_hz === null ? null : `${Number(rate_hz.toPrecision(3))} Hz`,
  ];
  return (
    <div className="inspector-topic">
      <p className="mono cut" title={name}>
        {name}
      </p>
      <p className="dim f11 cut" title={about.filter(Boolean).join(" · ")}>
        {about.filter(Boolean).join(" · ")}
      </p>
      <Numbers topic={name} />
    </div>
  );
}

/** A button for each number of a topic, which adds it to the plots. */
export function Numbers({ topic }: { topic: string }) {
  const traces = useTraces((state) => state.traces);
  const experiment = useRun((run) => run.experiment);
  const offered = useMemo(
    () =>
      offeredTraces(
        wire.offered().filter((channel) => channel.topic === topic),
        experiment?.devices ?? [],
        experiment?.topics ?? [],
      ),
    [topic, experiment],
  );
  if (offered.length === 0) return null;
  return (
    <details className="inspector-numbers">
      <summary>Add to plot</summary>
      <ul>
        {offered.map((trace) => {
          const plotted = traces.some((one) => one.topic === topic && one.path === trace.path);
          return (
            <li key={trace.path}>
              <button
                type="button"
                className="chip mono"
                aria-label={`Add ${trace.path} to the plot`}
                aria-pressed={plotted}
                draggable
                onDragStart={(event) => dragTrace(event.dataTransfer, trace)}
                onClick={() => addTrace(trace)}
              >
                <Icon name={plotted ? "check" : "plus"} small />
                {trace.path}
              </button>
            </li>
          );
        })}
      </ul>
    </details>
  );
}
