import { command, restore, runTo } from "../state/commands";
import { notify } from "../state/notices";
import type { Reach } from "./reach";
import { seconds } from "./reach";

let seeking = false;
let next: number | null = null;

/** A shorter way back is over before one could read how long it took. */
const NOTICEABLE_S = 0.1;

/**
 * Seeks, one call at a time: a drag that is faster than the server skips to its latest time. Returns whether this call
 * arrived there.
 */
async function seekLatest(t_s: number): Promise<boolean> {
  next = t_s;
  if (seeking) return false;
  seeking = true;
  let arrived = false;
  while (next !== null) {
    const now: number = next;
    next = null;
    arrived = (await command("seek", { t_s: now })) !== null;
  }
  seeking = false;
  return arrived;
}

/** Goes where a `Reach` says; a refusal is a notice. */
export async function go(reach: Reach): Promise<void> {
  const began_ms = performance.now();
  const took_s = () => (performance.now() - began_ms) / 1000;
  switch (reach.act) {
    case "seek":
      await seekLatest(reach.t_s);
      return;
    case "back":
      if ((await seekLatest(reach.t_s)) && took_s() > NOTICEABLE_S)
        notify(`Went back to ${seconds(reach.t_s)} in ${seconds(took_s())}.`);
      return;
    case "run":
      await runTo(reach.t_s);
      return;
    case "restore":
      if (await restore(reach.id))
        notify(`Restored the snapshot of ${seconds(reach.t_s)} in ${seconds(took_s())}.`);
      return;
    case "none":
      notify(reach.says);
  }
}
