import { Wire } from "./client";
import { addressOf } from "./socket";

/** The page's connection; `main.tsx` opens it. */
export const wire = new Wire(addressOf(window.location));
