import { BaseEdge, type EdgeProps, getBezierPath } from "@xyflow/react";
import { useEffect, useMemo, useRef, useState } from "react";
import { useRun, useTimesBack } from "../state/run";
import type { Experiment } from "../state/types";
import { useRarely } from "../ui/useRarely";
import { wire } from "../wire";
import { type Carried, fitted, rateText, sourceOf, textOf } from "./wireValue";

/** How often a value is written anew (ms). */
const EVERY_MS = 250;
const NOTHING: Pick<Experiment, "topics" | "devices"> = { topics: [], devices: [] };

/** A wire of functions, with its latest value in the run. */
export function LiveWire(props: EdgeProps) {
  const { style, data, markerEnd } = props;
  const text = useValue((data?.carries as Carried | null | undefined) ?? null);
  const [path, labelX, labelY] = getBezierPath(props);
  return (
    <BaseEdge
      path={path}
      label={<Lines text={fitted(text, Math.abs(props.targetX - props.sourceX))} />}
      labelX={labelX}
      labelY={labelY}
      {...(markerEnd ? { markerEnd } : {})}
      {...(style ? { style } : {})}
    />
  );
}

/** Lines of a text in SVG, about the middle. */
function Lines({ text }: { text: string }) {
  const lines = text.split("\n");
  return lines.map((line, at) => (
    // biome-ignore lint/suspicious/noArrayIndexKey: lines have no other name
    <tspan key={at} x={0} dy={at === 0 ? `${0.3 - 0.6 * (lines.length - 1)}em` : "1.2em"}>
      {line}
    </tspan>
  ));
}

/** The latest value of what a wire carries, as text; after a way back in time only what was said since. */
export function useValue(carried: Carried | null): string {
  const experiment = useRun((run) => run.experiment);
  const source = useMemo(() => sourceOf(carried, experiment ?? NOTHING), [carried, experiment]);
  const latest = useRef(new Map<string, { message: unknown; t_s: number }>());
  const [text, setText] = useState(textOf([], ""));
  const topics = source?.topics.join(" ") ?? "";
  const unit = source?.unit ?? "";
  const rarely = useRarely(EVERY_MS, () => {
    const known = topics.split(" ").flatMap((topic) => latest.current.get(topic) ?? []);
    setText(
      textOf(
        known.map(({ message }) => message),
        unit,
      ),
    );
  });
  useEffect(() => {
    latest.current.clear();
    rarely.ask();
    const stops = topics
      .split(" ")
      .filter(Boolean)
      .map((topic) =>
        wire.subscribe(
          topic,
          (message, t_s) => {
            latest.current.set(topic, { message, t_s });
            rarely.ask();
          },
          "latest",
        ),
      );
    return () => {
      for (const stop of stops) stop();
    };
  }, [topics, rarely]);
  const back = useTimesBack();
  // biome-ignore lint/correctness/useExhaustiveDependencies: what was said later is not true any more
  useEffect(() => {
    const now_s = useRun.getState().status?.t_s ?? 0;
    for (const [topic, { t_s }] of latest.current) if (t_s > now_s + 1e-9) latest.current.delete(topic);
    rarely.ask();
  }, [back, rarely]);
  return source && source.topics.length === 0 ? rateText(source.rate_hz) : text;
}
