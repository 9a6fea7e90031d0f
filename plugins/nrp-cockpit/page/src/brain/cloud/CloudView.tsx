import { useEffect, useRef, useState } from "react";
import { clock } from "../../plots/clock";
import { rolesOf } from "../../state/cells";
import { select } from "../../state/selection";
import type { Device, Population } from "../../state/types";
import { useView } from "../../state/view";
import { Empty } from "../../ui/Panel";
import { wire } from "../../wire";
import { Cloud, type Placed } from "./cloud";
import { placesIn } from "./places";
import { steer } from "./steer";

interface CloudProps {
  populations: readonly Population[];
  devices: readonly Device[];
}

const INKS = { sensor: "--d-blue", circuit: "--d-vermillion", actor: "--d-green" };

/** The cells that have positions, in space; they shine when they fire. */
export default function CloudView({ populations, devices }: CloudProps) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const cloud = useRef<Cloud | null>(null);
  const dark = useView((view) => view.dark);
  const [placed, setPlaced] = useState<readonly Placed[] | string | null>(null);
  useEffect(() => {
    let open = true;
    loaded(populations, devices).then(
      (all) => open && setPlaced(all),
      (error: Error) => open && setPlaced(error.message),
    );
    return () => {
      open = false;
    };
  }, [populations, devices]);
  useEffect(() => {
    if (!canvas.current || placed === null || typeof placed === "string") return;
    let made: Cloud;
    try {
      made = new Cloud(canvas.current, placed, () => clock.now_s);
    } catch {
      setPlaced("The view in space needs WebGL, which this browser does not support.");
      return;
    }
    cloud.current = made;
    const leave = [
      steer(canvas.current, made, (x, y) => {
        const cell = made.cellAt(x, y);
        select(cell && { kind: "neuron", ...cell });
      }),
      clock.onTick(() => made.moved()),
      () => made.dispose(),
    ];
    return () => {
      cloud.current = null;
      for (const stop of leave) stop();
    };
  }, [placed]);
  // biome-ignore lint/correctness/useExhaustiveDependencies: the colours are read anew when the theme changes
  useEffect(() => cloud.current?.style(), [dark]);
  if (typeof placed === "string") return <Empty>{placed}</Empty>;
  const labels = populations.filter((one) => one.placed).map(({ label }) => label);
  return (
    // biome-ignore lint/a11y/noInteractiveElementToNoninteractiveRole: it acts on keys of its own
    <canvas
      ref={canvas}
      className="panel-canvas"
      tabIndex={0}
      role="application"
      aria-label={`The cells of ${labels.join(", ")} in space: arrows orbit, plus and minus zoom`}
    />
  );
}

async function loaded(populations: readonly Population[], devices: readonly Device[]): Promise<Placed[]> {
  return Promise.all(
    populations
      .filter(({ placed }) => placed)
      .map(async (population) => {
        const { label } = population;
        const { base64 } = await wire.call<{ base64: string }>("/cockpit/positions", { population: label });
        const colours = rolesOf(population, devices).map((role) => INKS[role]);
        return { label, places: placesIn(base64), colours };
      }),
  );
}
