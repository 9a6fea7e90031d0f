import { type FormEvent, useState } from "react";
import { isStatic, poseOf, put } from "../scene/editing";
import { push } from "../state/commands";
import { useBlocked, useMissing } from "../state/run";
import type { Vector } from "../state/types";
import { Button } from "../ui/Button";
import { Field } from "../ui/Field";
import { fromRollPitchYaw, IDENTITY, rollPitchYaw, yawOf } from "../world/pose";
import { Section } from "./Facts";
import { degrees, fixed, isZero, parseNumbers, radians } from "./numbers";

/** Why bodies cannot be moved, or pushed, now. */
function useRefused(capability: "place" | "push"): string | undefined {
  const blocked = useBlocked();
  const missing = useMissing(capability);
  return blocked ?? missing;
}

/** What a form does with its numbers. */
interface NumbersFormProps<K extends string> {
  /** The labels of the fields, with their units. */
  labels: Readonly<Record<K, string>>;
  initial: Readonly<Record<K, string>>;
  action: string;
  icon: "move" | "push";
  refused: string | undefined;
  onSubmit: (values: Record<K, number>) => void;
}

function NumbersForm<K extends string>(props: NumbersFormProps<K>) {
  const { labels, initial, action, icon, refused, onSubmit } = props;
  const [texts, setTexts] = useState(initial);
  const [tried, setTried] = useState(false);
  const { values, errors, ok } = parseNumbers(texts);
  const submit = (event?: FormEvent) => {
    event?.preventDefault();
    setTried(true);
    if (ok && refused === undefined) onSubmit(values);
  };
  return (
    <form onSubmit={submit} noValidate>
      {(Object.keys(labels) as K[]).map((key) => (
        <Field
          key={key}
          label={labels[key]}
          inputMode="decimal"
          value={texts[key]}
          error={tried ? errors[key] : undefined}
          onChange={(text) => setTexts((now) => ({ ...now, [key]: text }))}
        />
      ))}
      <Button icon={icon} small disabled={refused} onClick={() => submit()}>
        {action}
      </Button>
    </form>
  );
}

/** Puts a body elsewhere, at rest, at the height that it has; one that moves stands upright there. */
export function PlaceBody({ body }: { body: string }) {
  const refused = useRefused("place");
  const [initial] = useState(() => {
    const pose = poseOf(body);
    const [x, y] = pose?.position ?? [0, 0];
    return { x: fixed(x, 2), y: fixed(y, 2), yaw: fixed(degrees(pose ? yawOf(pose.orientation) : 0), 0) };
  });
  return (
    <Section title="Move">
      <NumbersForm
        labels={{ x: "x (m)", y: "y (m)", yaw: "yaw (°)" }}
        initial={initial}
        action="Place"
        icon="move"
        refused={refused}
        onSubmit={({ x, y, yaw }) => {
          const pose = poseOf(body) ?? IDENTITY;
          const [roll, pitch] = isStatic(body) ? rollPitchYaw(pose.orientation) : [0, 0];
          void put(body, {
            position: [x, y, pose.position[2]],
            orientation: fromRollPitchYaw(roll, pitch, radians(yaw)),
          });
        }}
      />
    </Section>
  );
}

const PUSH_S = "0.2";

/** Pushes a body with a force along the axes of the room. */
export function PushBody({ body }: { body: string }) {
  const refused = useRefused("push");
  return (
    <Section title="Push">
      <NumbersForm
        labels={{ x: "x (N)", y: "y (N)", z: "z (N)", duration: "for (s)" }}
        initial={{ x: "100", y: "0", z: "0", duration: PUSH_S }}
        action="Push"
        icon="push"
        refused={refused}
        onSubmit={({ x, y, z, duration }) => {
          const force: Vector = [x, y, z];
          if (!isZero(force)) void push(body, force, duration);
        }}
      />
    </Section>
  );
}
