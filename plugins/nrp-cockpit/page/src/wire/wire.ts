import { Wire } from "./client";
import { Player } from "./player";
import { isPlayed } from "./recording";
import { addressOf, Socket } from "./socket";

/** The page's connection; `main.tsx` opens it. */
export const wire = new Wire((listener) =>
  isPlayed() ? new Player(listener) : new Socket(addressOf(window.location), listener),
);
