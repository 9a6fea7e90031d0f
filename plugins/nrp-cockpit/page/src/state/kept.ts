/** What the browser keeps for this page from visit to visit; where it refuses (some mail programs), nothing. */
export function kept(key: string): string | null {
  try {
    return localStorage.getItem(key);
  } catch {
    return null;
  }
}

export function keep(key: string, value: string): void {
  try {
    localStorage.setItem(key, value);
  } catch {
    // the page goes on without
  }
}
