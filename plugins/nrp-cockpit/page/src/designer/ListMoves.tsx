import { IconButton } from "../ui/Button";
import { act } from "./store";

/** Moves an item of a list: functions and variables act in their order. */
export function ListMoves({ path }: { path: string }) {
  const place = Number(path.slice(path.lastIndexOf("/") + 1));
  return (
    <>
      {place > 0 && (
        <IconButton
          icon="up"
          label="Earlier"
          kind="ghost"
          small
          onClick={() => void act("move", { path, to: place - 1 })}
        />
      )}
      <IconButton
        icon="down"
        label="Later"
        kind="ghost"
        small
        onClick={() => void act("move", { path, to: place + 1 })}
      />
    </>
  );
}
