import { command, restore, runTo } from "../state/commands";
import { notify } from "../state/notices";
import type { Reach } from "./reach";
import { seconds } from "./reach";

let seeking = false;
let next: number | null = null;

/** Seeks, one call at a time: a drag that is faster than the server skips to its latest time. */
async function seekLatest(t_s: number): Promise<void> {
  next = t_s;
  if (seeking) return;
  seeking = true;
  while (next !== null) {
    const now: number = next;
    next = null;
    await command("seek", { t_s: now });
  }
  seeking = false;
}

/** Goes where a `Reach` says. A refusal is a notice only if `aloud`: under a pointer its tip already says it. */
export async function go(reach: Reach, aloud: boolean): Promise<void> {
  switch (reach.act) {
    case "seek":
      return seekLatest(reach.t_s);
    case "run":
      await runTo(reach.t_s);
      return;
    case "restore":
      if (await restore(reach.id)) notify(`Restored the snapshot of ${seconds(reach.t_s)}.`);
      return;
    case "none":
      if (aloud) notify(reach.says);
  }
}
