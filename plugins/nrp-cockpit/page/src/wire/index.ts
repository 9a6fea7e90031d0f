/** The door of the wire: the one connection, and the hook by which a room hears a topic. */
export { CallError } from "./calls";
export type { Channel } from "./frames";
export { hearAll, onPast, PAST, type Past } from "./past";
export type { Link } from "./socket";
export type { Handler } from "./subscriptions";
export { useTopic } from "./useTopic";
export { wire } from "./wire";
