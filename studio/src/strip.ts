// A strip chart: the newest readings of a whisker.

import { element } from "./controls";
import { colour } from "./plot";

/** Pixels from top to bottom. */
const HEIGHT = 76;

export class Strip {
  private readonly canvas = element("canvas", { role: "img", "aria-label": "The newest readings" });
  private readonly frame: HTMLElement;
  private readonly times: number[] = [];
  private readonly values: number[] = [];
  private width = 600;
  private at: number | undefined;
  private readonly observer: ResizeObserver;

  /** So many seconds are shown; values are moments (N m). */
  constructor(parent: HTMLElement, private readonly seconds: number) {
    this.frame = element("div", { class: "strip" }, element("span", { class: "strip-words" }, "reading, mN\u202fm"), this.canvas);
    parent.append(this.frame);
    this.width = this.frame.clientWidth || 600;
    this.observer = new ResizeObserver(() => {
      this.width = this.frame.clientWidth || 600;
      this.draw(this.at);
    });
    this.observer.observe(this.frame);
  }

  end(): void {
    this.observer.disconnect();
  }

  clear(): void {
    this.times.length = this.values.length = 0;
  }

  add(t: number, value: number): void {
    this.times.push(t);
    this.values.push(value);
    while (this.times[0] < t - this.seconds) {
      this.times.shift();
      this.values.shift();
    }
  }

  /** All values at once, and where one looks. */
  set(times: number[], values: number[]): void {
    this.clear();
    this.times.push(...times);
    this.values.push(...values);
  }

  draw(at?: number): void {
    this.at = at;
    const [width, height] = [this.width, HEIGHT];
    const dense = window.devicePixelRatio || 1;
    if (this.canvas.width !== Math.round(width * dense)) {
      this.canvas.width = Math.round(width * dense);
      this.canvas.height = Math.round(height * dense);
    }
    const pen = this.canvas.getContext("2d")!;
    pen.setTransform(dense, 0, 0, dense, 0, 0);
    pen.clearRect(0, 0, width, height);
    const most = Math.max(2e-3, ...this.values.map(Math.abs));
    const last = this.times.at(-1) ?? 0;
    const first = Math.min(this.times[0] ?? 0, last - (Number.isFinite(this.seconds) ? this.seconds : 0));
    const x = (t: number) => ((t - first) / (last - first || 1)) * width;
    const y = (v: number) => height / 2 - (v / most) * (height / 2 - 8);
    pen.strokeStyle = colour("faint");
    pen.lineWidth = 1;
    pen.beginPath();
    pen.moveTo(0, y(0));
    pen.lineTo(width, y(0));
    pen.stroke();
    pen.fillStyle = colour("soft");
    pen.font = "11px system-ui, sans-serif";
    pen.fillText(`+${(1e3 * most).toFixed(1)}`, 4, 13);
    pen.fillText(`−${(1e3 * most).toFixed(1)}`, 4, height - 4);
    pen.strokeStyle = colour("touch");
    pen.lineWidth = 1.6;
    pen.lineJoin = "round";
    pen.beginPath();
    this.times.forEach((t, i) => (i ? pen.lineTo(x(t), y(this.values[i])) : pen.moveTo(x(t), y(this.values[i]))));
    pen.stroke();
    if (at !== undefined) {
      pen.strokeStyle = colour("ink");
      pen.beginPath();
      pen.moveTo(x(at), 0);
      pen.lineTo(x(at), height);
      pen.stroke();
    }
  }
}
