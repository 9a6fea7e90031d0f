import { useContext, useRef, useState } from "react";
import { usePanelChoice } from "../state/panelChoices";
import { PanelContext } from "../state/panelContext";
import { useRecorded, useRun } from "../state/run";
import type { TopicInfo } from "../state/types";
import { Icon } from "../ui/Icon";
import { Menu } from "../ui/Menu";
import { Empty, Panel } from "../ui/Panel";
import { PAST, type Past, useTopic, wire } from "../wire";
import { type AnyImage, drawImage } from "./drawImage";
import "./camera.css";

const IMAGE = /^sensor_msgs\/(msg\/)?(Compressed)?Image$/;
const NONE: readonly TopicInfo[] = [];

export const isCamera = ({ type }: TopicInfo): boolean => IMAGE.test(type);

/** What a camera of the run sees. */
export function CameraPanel() {
  const topics = useRun((run) => run.experiment?.topics ?? NONE);
  const cameras = topics.filter(isCamera);
  const { number } = useContext(PanelContext);
  const [chosen, setChosen] = usePanelChoice<string>("");
  const camera = cameras.find(({ name }) => name === chosen) ?? cameras[(number - 1) % cameras.length];
  if (!camera)
    return (
      <Panel title="Camera">
        <Empty>{topics.length === 0 ? "Waiting for the topics." : "This run has no camera."}</Empty>
      </Panel>
    );
  const items = cameras.map(({ name }) => ({ label: name, onSelect: () => setChosen(name) }));
  const tools = (
    <>
      {camera.rate_hz !== null && <span className="panel-sub">{camera.rate_hz} Hz</span>}
      {cameras.length > 1 && (
        <Menu label={`Camera: ${camera.name}`} items={items} className="btn btn-small btn-ghost btn-icon">
          <Icon name="down" />
        </Menu>
      )}
    </>
  );
  return (
    <Panel title="Camera" sub={camera.name} tools={tools} className="camera">
      <CameraView key={camera.name} topic={camera.name} />
    </Panel>
  );
}

type Shown = "nothing" | "picture" | { failure: string };

function CameraView({ topic }: { topic: string }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const caption = useRef<HTMLParagraphElement>(null);
  const [shown, setShown] = useState<Shown>("nothing");
  const recorded = useRecorded();
  const told = useRef(shown);
  /** React keeps each state that it is given until it renders, also the same one again. */
  const show = (next: Shown) => {
    if (next === told.current) return;
    told.current = next;
    setShown(next);
  };
  /** The number of the last image, and of the last one that is shown or not true any more. */
  const last = useRef(0);
  const done = useRef(0);
  useTopic<Past>(PAST, (past) => {
    if (past.topic !== topic) return;
    wire.skip(topic);
    done.current = last.current; // an image that is being decoded is not shown either
    if (past.count === 0) show("nothing");
  });
  useTopic<AnyImage>(
    topic,
    (image) => {
      if (!canvas.current) return;
      const number = ++last.current;
      drawImage(canvas.current, image, () => number <= done.current)
        .then((range) => {
          if (range === undefined) return;
          done.current = number;
          const text = range ? `${range[0].toFixed(2)} m to ${range[1].toFixed(2)} m` : "";
          if (caption.current && caption.current.textContent !== text) caption.current.textContent = text;
          show("picture");
        })
        .catch((error: Error) => show({ failure: error.message }));
    },
    "latest",
  );
  return (
    <>
      <canvas ref={canvas} role="img" aria-label={`The image of ${topic}`} hidden={shown !== "picture"} />
      <p ref={caption} className="camera-range num" hidden={shown !== "picture"} />
      {shown === "nothing" && (
        <Empty>{recorded ? `No image of ${topic} at this time.` : `Waiting for ${topic}`}</Empty>
      )}
      {typeof shown === "object" && <Empty>{shown.failure}</Empty>}
    </>
  );
}
