import { useEffect, useState } from "react";
import { Icon } from "../ui/Icon";
import { Menu } from "../ui/Menu";
import { partAt, titleOf } from "./model";
import { act, fits, useDesign } from "./store";
import type { DesignState } from "./types";

const MOST = 16;

const nameOf = (state: DesignState, end: string): string => {
  const part = partAt(state.model, end);
  return part && end !== "" ? titleOf(part) : end.slice(end.indexOf(":") + 1);
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
  const items = fitting.slice(0, MOST).map((target) => ({
    label: nameOf(state, target),
    onSelect: () => void act("connect", { source, target }),
  }));
  return (
    <p className="form-action">
      <Menu label="Connect to" items={items} className="btn">
        Connect to
        <Icon name="down" small />
      </Menu>
    </p>
  );
}
