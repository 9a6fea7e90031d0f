import { wire } from "./wire";

/** What the server says before it sends the past of a topic that the page subscribed to. */
export interface Past {
  topic: string;
  /** The time from which the topic is known. */
  from_s: number;
  /** How many messages of it follow. */
  count: number;
  /** Whether all that was known before is invalid. */
  new: boolean;
}

export const PAST = "/cockpit/past";

/** Calls back before the past of any topic comes. */
export const onPast = (listener: (past: Past) => void): (() => void) => wire.subscribe<Past>(PAST, listener);
