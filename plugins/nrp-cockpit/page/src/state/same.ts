/** A description with the parts of the one before that are equal, so that nothing is drawn anew for their sake. */
export function keepSame<T extends object>(before: T | null, next: T): T {
  if (before === null) return next;
  const parts = Object.entries(next).map(([name, part]) => {
    const old = before[name as keyof T];
    return [name, JSON.stringify(old) === JSON.stringify(part) ? old : part];
  });
  return Object.fromEntries(parts) as T;
}
