/** Stands in a shared file for a view that it does not have. */
export default function Nothing() {
  return null;
}
