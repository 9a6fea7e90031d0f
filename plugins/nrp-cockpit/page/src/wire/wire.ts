import { Player } from "../played/player";
import { isPlayed } from "../played/recording";
import { Wire } from "./client";
import { addressOf, Socket } from "./socket";

/** The page's connection; `main.tsx` opens it. */
export const wire = new Wire((listener) =>
  isPlayed() ? new Player(listener) : new Socket(addressOf(window.location), listener),
);
