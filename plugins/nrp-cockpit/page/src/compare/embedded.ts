/** The address of the page that shows one of two runs inside this one: no bars, a few panels. */
export function embeddedAddress(page: Pick<Location, "pathname" | "search">, run: string): string {
  const token = new URLSearchParams(page.search).get("token") ?? "";
  return `${page.pathname}?${new URLSearchParams({ token, run, embedded: "" })}`;
}
