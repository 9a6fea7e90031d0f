import type { Status } from "../state/types";
import { wire } from "../wire";
import { SimClock } from "./simClock";

/** The one clock of the plots. */
export const clock = new SimClock();

// Heard as long as the page lives, so that no panel that opens later keeps what a seek undid.
wire.subscribe<Status>("/cockpit/status", ({ t_s, state }) => clock.run(t_s, state === "running"));
