import { useEffect, useState } from "react";
import { Chooser } from "../ui/Chooser";
import { partAt, titleOf } from "./model";
import { act, fits, useDesign } from "./store";
import type { DesignState } from "./types";

const nameOf = (state: DesignState, end: string): string => {
  const [path = "", cells] = end.replace(/^into:/, "").split(/(?=\[)/);
  const part = end.includes("/") && partAt(state.model, path);
  return part ? titleOf(part) + (cells ?? "") : end.slice(end.indexOf(":") + 1);
};

/** Draws a wire without a drag: a list of what fits. */
export function ConnectMenu({ source }: { source: string }) {
  const state = useDesign((design) => design.state);
  const [fitting, setFitting] = useState<string[]>([]);
  const revision = state?.revision;
  useEffect(() => {
    let isOpen = revision !== undefined;
    void fits(source).then((answer) => {
      if (answer && isOpen)
        setFitting(Object.keys(answer.refusals).filter((end) => answer.refusals[end] === null));
    });
    return () => {
      isOpen = false;
    };
  }, [source, revision]);
  if (!state || fitting.length === 0) return null;
  return (
    <p className="form-action">
      <Chooser
        title={`Connect ${nameOf(state, source)}`}
        search="Search the valid ends"
        choices={() => fitting.map((end) => ({ end, name: nameOf(state, end) }))}
        textOf={({ name }) => name}
        none="No valid end matches."
        onChoose={({ end }) => void act("connect", { source, target: end })}
      >
        Connect to
      </Chooser>
    </p>
  );
}
