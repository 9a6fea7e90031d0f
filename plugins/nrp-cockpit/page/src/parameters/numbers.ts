/** A number of the run that can be changed, as the server tells of it. */
export interface ChangeableNumber {
  name: string;
  /** null: cells have different ones. */
  value: number | null;
  /** The ends of its slider; values beyond them are possible. */
  low: number;
  high: number;
  whole: boolean;
  /** Its unit, or what its comment says. */
  note: string;
}

export interface Parameters {
  functions: { file: string; numbers: ChangeableNumber[] }[];
  populations: { population: string; index: number | null; numbers: ChangeableNumber[] }[];
}

const STEPS = 200;
const DIGITS = 6;

/** The step of a slider: one of 1, 2 and 5 times a power of ten, and at least 1 for whole numbers. */
export function stepOf({ low, high, whole }: ChangeableNumber): number {
  const fine = (high - low) / STEPS;
  const power = 10 ** Math.floor(Math.log10(fine));
  const step = ([1, 2, 5].find((one) => one * power >= fine * (1 - 1e-9)) ?? 10) * power;
  return whole ? Math.max(1, Math.round(step)) : Number(step.toPrecision(1));
}

/** A number without the digits that only the binary system needs. */
export const shortened = (value: number): number => Number(value.toPrecision(DIGITS));

/** Asks for one thing at a time, with a rest (ms) after each; of all that is asked meanwhile, only the last is. */
export class LatestOnly {
  private next: (() => Promise<unknown>) | null = null;
  private busy = false;

  constructor(private readonly rest_ms = 0) {}

  async ask(call: () => Promise<unknown>): Promise<void> {
    this.next = call;
    if (this.busy) return;
    this.busy = true;
    while (this.next) {
      const now: () => Promise<unknown> = this.next;
      this.next = null;
      await now();
      if (this.rest_ms > 0) await new Promise((resolve) => setTimeout(resolve, this.rest_ms));
    }
    this.busy = false;
  }
}
