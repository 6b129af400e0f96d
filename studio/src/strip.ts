// A strip chart: readings over time, with gaps where none came.

import { element } from "./controls";
import { colour } from "./plot";

/** Pixels from top to bottom. */
const HEIGHT = 76;
/** So many times the usual step without a value is a gap, and at least so long (s). */
const GAP = 6;
const LEAST_GAP = 0.03;
/** Values that are kept. */
const KEPT = 400000;

export interface StripOptions {
  /** What is drawn, with its unit. */
  words: string;
  /** How much of that unit an SI unit is, and how much the chart shows at least (SI). */
  scale: number;
  least: number;
}

const MOMENT: StripOptions = { words: "reading, mN\u202fm", scale: 1e3, least: 2e-3 };

/** Places of the first value that is not before a time. */
function firstAt(times: number[], t: number): number {
  let [from, to] = [0, times.length];
  while (from < to) {
    const middle = (from + to) >> 1;
    if (times[middle] < t) from = middle + 1;
    else to = middle;
  }
  return from;
}

export class Strip {
  private readonly canvas = element("canvas", { role: "img" });
  private readonly frame: HTMLElement;
  private readonly times: number[] = [];
  private readonly values: number[] = [];
  /** When something was lost. */
  private readonly losses: number[] = [];
  private width = 600;
  private at: number | undefined;
  private until: number | undefined;
  private readonly observer: ResizeObserver;

  /** So many seconds are shown. */
  constructor(parent: HTMLElement, private readonly seconds: number, private readonly options = MOMENT) {
    this.canvas.setAttribute("aria-label", `The newest readings: ${options.words}`);
    this.frame = element("div", { class: "strip" }, element("span", { class: "strip-words" }, options.words), this.canvas);
    parent.append(this.frame);
    this.width = this.frame.clientWidth || 600;
    this.observer = new ResizeObserver(() => {
      this.width = this.frame.clientWidth || 600;
      this.draw(this.at, this.until);
    });
    this.observer.observe(this.frame);
  }

  end(): void {
    this.observer.disconnect();
  }

  clear(): void {
    this.times.length = this.values.length = this.losses.length = 0;
  }

  add(t: number, value: number): void {
    this.times.push(t);
    this.values.push(value);
    if (this.times.length > KEPT) {
      this.times.splice(0, KEPT / 4);
      this.values.splice(0, KEPT / 4);
    }
  }

  lost(t: number): void {
    this.losses.push(t);
    if (this.losses.length > KEPT / 100) this.losses.shift();
  }

  /** All values at once. */
  set(times: number[], values: number[]): void {
    this.clear();
    for (let i = 0; i < times.length; i++) this.add(times[i], values[i]);
  }

  /** Runs of values without a gap, within what is shown. */
  private runs(from: number, to: number): [number, number][] {
    const { times } = this;
    const usual = to > from + 1 ? (times[to - 1] - times[from]) / (to - 1 - from) : 0;
    const gap = Math.max(LEAST_GAP, GAP * usual);
    const runs: [number, number][] = [];
    let begin = from;
    for (let i = from + 1; i <= to; i++) {
      if (i === to || times[i] - times[i - 1] > gap) {
        runs.push([begin, i]);
        begin = i;
      }
    }
    return runs;
  }

  /** What is shown: the last `seconds` before `until`, or before the newest value. */
  private window(): { first: number; last: number; from: number; to: number } {
    const { times } = this;
    const last = this.until ?? times.at(-1) ?? 0;
    const first = Number.isFinite(this.seconds) ? last - this.seconds : times[0] ?? 0;
    // One value beyond each end carries the line to it.
    return { first, last, from: Math.max(0, firstAt(times, first) - 1), to: Math.min(times.length, firstAt(times, last + 1e-9) + 1) };
  }

  /** How many gaps are shown, for tests. */
  gaps(): number {
    const { from, to } = this.window();
    return Math.max(0, this.runs(from, to).length - 1);
  }

  draw(at?: number, until?: number): void {
    this.at = at;
    this.until = until;
    const { times, values, options, width } = this;
    const dense = window.devicePixelRatio || 1;
    if (this.canvas.width !== Math.round(width * dense)) {
      this.canvas.width = Math.round(width * dense);
      this.canvas.height = Math.round(HEIGHT * dense);
    }
    const pen = this.canvas.getContext("2d")!;
    pen.setTransform(dense, 0, 0, dense, 0, 0);
    pen.clearRect(0, 0, width, HEIGHT);
    const { first, last, from, to } = this.window();
    let most = options.least;
    for (let i = from; i < to; i++) most = Math.max(most, Math.abs(values[i]));
    const x = (t: number) => ((t - first) / (last - first || 1)) * width;
    const y = (v: number) => HEIGHT / 2 - (v / most) * (HEIGHT / 2 - 8);
    const runs = this.runs(from, to);
    pen.fillStyle = colour("fill");
    runs.slice(1).forEach(([begin], i) => {
      const [a, b] = [x(times[runs[i][1] - 1]), x(times[begin])];
      pen.fillRect(a, 0, b - a, HEIGHT);
    });
    pen.strokeStyle = colour("faint");
    pen.lineWidth = 1;
    pen.beginPath();
    pen.moveTo(0, y(0));
    pen.lineTo(width, y(0));
    pen.stroke();
    pen.fillStyle = colour("soft");
    pen.font = "11px system-ui, sans-serif";
    pen.fillText(`+${(options.scale * most).toFixed(1)}`, 4, 13);
    pen.fillText(`−${(options.scale * most).toFixed(1)}`, 4, HEIGHT - 4);
    pen.strokeStyle = colour("touch");
    pen.lineWidth = 1.6;
    pen.lineJoin = "round";
    pen.beginPath();
    for (const [begin, end] of runs) this.line(pen, begin, end, x, y);
    pen.stroke();
    pen.fillStyle = colour("bad");
    for (let i = this.losses.length - 1; i >= 0 && this.losses[i] >= first; i--) {
      if (this.losses[i] <= last) pen.fillRect(x(this.losses[i]) - 1, 0, 2.5, 9);
    }
    if (at !== undefined) {
      pen.strokeStyle = colour("ink");
      pen.lineWidth = 1.2;
      pen.beginPath();
      pen.moveTo(x(at), 0);
      pen.lineTo(x(at), HEIGHT);
      pen.stroke();
    }
  }

  /** A run as a line; of values that share a pixel the first, the least and the largest. */
  private line(pen: CanvasRenderingContext2D, begin: number, end: number, x: (t: number) => number, y: (v: number) => number): void {
    const { times, values } = this;
    if (end === begin + 1) {
      pen.rect(x(times[begin]) - 0.5, y(values[begin]) - 0.5, 1, 1);
      return;
    }
    pen.moveTo(x(times[begin]), y(values[begin]));
    for (let i = begin + 1; i < end; ) {
      const column = Math.round(x(times[i]));
      let [least, largest, k] = [values[i], values[i], i];
      while (k < end && Math.round(x(times[k])) === column) {
        least = Math.min(least, values[k]);
        largest = Math.max(largest, values[k]);
        k += 1;
      }
      pen.lineTo(x(times[i]), y(values[i]));
      if (k > i + 1) {
        pen.lineTo(column, y(least));
        pen.lineTo(column, y(largest));
        pen.lineTo(x(times[k - 1]), y(values[k - 1]));
      }
      i = k;
    }
  }
}
