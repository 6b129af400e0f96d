// Rows on their way to a method in a worker: where it is behind, the newest of each stretch stands for the others, as in a live run.

/** Rows that the worker has before it, so that it never waits for the page; with more of them the others wait here. */
const AHEAD = 8;
/** Rows that wait here: of more the newest of each stretch are handed over, so many in all. */
const AT_ONCE = 32;

export class Backlog {
  /** For each row that was handed over the number of the last row that it stands for, counted from 1. */
  private readonly stand: number[];
  private taken = 0;
  private waiting: number[][] = [];

  /** The first rows are handed over whole. */
  constructor(private all: number) {
    this.stand = Array.from({ length: all }, (_, i) => i + 1);
  }

  /** Rows came. */
  add(rows: Float64Array, width: number): void {
    for (let i = 0; i < rows.length; i += width) this.waiting.push([...rows.subarray(i, i + width)]);
    this.all += rows.length / width;
  }

  /** The worker has taken so many of those that were handed over. */
  took(count: number): void {
    this.taken = count;
  }

  /** What is to be handed over now; nothing where the worker still has enough. */
  due(): Float64Array | undefined {
    const { waiting } = this;
    const count = waiting.length;
    if (!count || this.stand.length - this.taken > AHEAD) return undefined;
    const before = this.all - count;
    const groups = Math.min(count, AT_ONCE);
    const last = Array.from({ length: groups }, (_, i) => Math.ceil(((i + 1) * count) / groups));
    this.stand.push(...last.map((row) => before + row));
    this.waiting = [];
    return Float64Array.from(last.flatMap((row) => waiting[row - 1]));
  }

  /** The number of the row that an estimate is of, after so many that were handed over. */
  row(handed: number): number {
    return handed > 0 ? this.stand[Math.min(handed, this.stand.length) - 1] : 0;
  }

  /** Rows that the method has not come to. */
  behind(): number {
    return this.all - this.row(this.taken);
  }
}
