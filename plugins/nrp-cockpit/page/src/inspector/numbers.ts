import type { Vector } from "../state/types";

/** Numbers as a person wrote them, and for each what is wrong with it. */
export interface Parsed<K extends string> {
  values: Record<K, number>;
  errors: Partial<Record<K, string>>;
  ok: boolean;
}

/** Reads numbers; a comma counts as a decimal point. */
export function parseNumbers<K extends string>(texts: Readonly<Record<K, string>>): Parsed<K> {
  const values = {} as Record<K, number>;
  const errors: Partial<Record<K, string>> = {};
  for (const key of Object.keys(texts) as K[]) {
    const text = texts[key].trim().replace(",", ".");
    values[key] = text === "" ? Number.NaN : Number(text);
    if (!Number.isFinite(values[key])) errors[key] = "Not a number.";
  }
  return { values, errors, ok: Object.keys(errors).length === 0 };
}

export const degrees = (rad: number): number => (rad * 180) / Math.PI;
export const radians = (deg: number): number => (deg * Math.PI) / 180;

/** A number with a fixed count of decimals, without a minus before a zero. */
export function fixed(value: number, decimals: number): string {
  const text = value.toFixed(decimals);
  return Number(text) === 0 ? text.replace("-", "") : text;
}

export const isZero = (vector: Readonly<Vector>): boolean => vector.every((value) => value === 0);
