import { command } from "../state/commands";

const REST_MS = 600;
let timer = 0;

/** Has the functions checked once a slider rests: the run takes each of its numbers at once, without a check. */
export function recheckSoon(): void {
  window.clearTimeout(timer);
  timer = window.setTimeout(() => void command("functions/recheck"), REST_MS);
}
