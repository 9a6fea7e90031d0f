type Stretch = [from_s: number, to_s: number];

/** The stretches of simulated time in which a series was heard, so that silence is not taken for a lack of data. */
export class Spans {
  private spans: Stretch[] = [];

  /** Begins a stretch that lasts until `end`. */
  begin(t_s: number): void {
    this.end(t_s);
    this.spans.push([t_s, Number.POSITIVE_INFINITY]);
  }

  end(t_s: number): void {
    const last = this.spans.at(-1);
    if (last?.[1] === Number.POSITIVE_INFINITY) last[1] = Math.max(last[0], t_s);
  }

  /** Drops what is later than a time; a stretch that has not ended goes on from there. */
  forgetFrom(t_s: number): void {
    const open = this.spans.at(-1)?.[1] === Number.POSITIVE_INFINITY;
    this.end(t_s);
    this.spans = this.spans
      .filter(([from_s]) => from_s < t_s)
      .map(([from_s, to_s]) => [from_s, Math.min(to_s, t_s)]);
    const last = this.spans.at(-1);
    if (open && last?.[1] === t_s) last[1] = Number.POSITIVE_INFINITY;
    else if (open) this.begin(t_s);
  }

  /** Drops what is earlier than a time. */
  forgetBefore(t_s: number): void {
    if ((this.spans[0]?.[0] ?? t_s) >= t_s) return;
    this.spans = this.spans
      .filter(([, to_s]) => to_s > t_s)
      .map(([from_s, to_s]) => [Math.max(from_s, t_s), to_s]);
  }

  /** Whether a time belongs to a stretch. */
  has(t_s: number): boolean {
    return this.spans.some(([from_s, to_s]) => from_s <= t_s && t_s <= to_s);
  }

  /** What was heard between two times. */
  within(from_s: number, to_s: number): Stretch[] {
    return this.spans
      .map(([begin_s, end_s]): Stretch => [Math.max(begin_s, from_s), Math.min(end_s, to_s)])
      .filter(([begin_s, end_s]) => end_s > begin_s);
  }

  /** What was not heard between two times. */
  gaps(from_s: number, to_s: number): Stretch[] {
    const edges = [from_s, ...this.within(from_s, to_s).flat(), to_s];
    const pairs = edges.flatMap((edge, at): Stretch[] =>
      at % 2 === 0 ? [[edge, edges[at + 1] ?? edge]] : [],
    );
    return pairs.filter(([begin_s, end_s]) => end_s > begin_s);
  }
}
