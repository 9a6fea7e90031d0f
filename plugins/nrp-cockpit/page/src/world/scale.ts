/**
 * How large things are: 1 in a room of people, and less on a table of insects, where lines, arrows and forces shrink
 * with it. The view of the scene measures it.
 */
export const scale = { unit: 1 };
