// A figure in world coordinates (m, y up): SVG for lines and handles over a canvas for many states.

import type { Outline, Point } from "./engine";

const SVG = "http://www.w3.org/2000/svg";
/** Places in one part of a trail, and parts that are kept. */
const PART = 48;
const MOST_PARTS = 90;
/** What of the page's styles a picture takes along, and what need not be said. */
const DRAWN = ["fill", "fill-opacity", "stroke", "stroke-width", "stroke-dasharray", "stroke-linecap", "stroke-linejoin", "opacity"];
const TEXT = [...DRAWN, "font-size", "font-family", "font-weight", "text-anchor", "paint-order"];
const PLAIN = new Set([
  "fill-opacity:1", "stroke:none", "stroke-dasharray:none", "stroke-linecap:butt", "stroke-linejoin:miter", "opacity:1", "font-weight:400",
  "text-anchor:start", "paint-order:normal",
]);

export interface Box {
  left: number;
  right: number;
  bottom: number;
  top: number;
}

export function boxOf(points: Point[], margin: number): Box {
  const [xs, ys] = [points.map((p) => p[0]), points.map((p) => p[1])];
  return {
    left: Math.min(...xs) - margin, right: Math.max(...xs) + margin,
    bottom: Math.min(...ys) - margin, top: Math.max(...ys) + margin,
  };
}

type Attributes = Record<string, string | number>;

export class Plot {
  readonly frame: HTMLElement;
  readonly svg: SVGSVGElement;
  readonly canvas: HTMLCanvasElement;
  /** Metres of one pixel. */
  pixel = 1e-3;
  /** Pixels of the frame across: asking the page for it between changes would lay it out anew. */
  private width = 600;
  private readonly layers = new Map<string, SVGGElement>();
  private readonly kept = new Map<string, SVGPathElement>();
  private readonly resized: () => void;
  private readonly observer: ResizeObserver;

  constructor(parent: HTMLElement, public box: Box, name: string, resized: () => void) {
    this.frame = document.createElement("div");
    this.frame.className = "plot";
    this.canvas = document.createElement("canvas");
    this.canvas.setAttribute("aria-hidden", "true");
    this.svg = document.createElementNS(SVG, "svg");
    this.svg.setAttribute("role", "group");
    this.svg.setAttribute("aria-label", name);
    this.frame.append(this.canvas, this.svg);
    parent.append(this.frame);
    this.resized = resized;
    this.fit();
    this.observer = new ResizeObserver(() => {
      this.fit();
      this.resized();
    });
    this.observer.observe(this.frame);
  }

  end(): void {
    this.observer.disconnect();
  }

  /** Shows another part of the world. */
  show(box: Box): void {
    this.box = box;
    this.fit();
  }

  private fit(): void {
    const { left, right, bottom, top } = this.box;
    this.frame.style.aspectRatio = `${(right - left).toFixed(5)} / ${(top - bottom).toFixed(5)}`;
    const width = this.frame.clientWidth || 600;
    this.width = width;
    this.pixel = (right - left) / width;
    const height = (top - bottom) / this.pixel;
    this.svg.setAttribute("viewBox", `0 0 ${width} ${height.toFixed(2)}`);
    const dense = window.devicePixelRatio || 1;
    this.canvas.width = Math.round(width * dense);
    this.canvas.height = Math.round(height * dense);
  }

  /** A place of the world on the page. */
  at([x, y]: Point): Point {
    return [(x - this.box.left) / this.pixel, (this.box.top - y) / this.pixel];
  }

  /** The place of the world under a pointer. */
  under(event: { clientX: number; clientY: number }): Point {
    const frame = this.svg.getBoundingClientRect();
    const scale = (this.box.right - this.box.left) / (frame.width || 1);
    return [this.box.left + (event.clientX - frame.left) * scale, this.box.top - (event.clientY - frame.top) * scale];
  }

  /** A layer of lines, made when it is first asked for; later ones lie above. */
  layer(name: string): SVGGElement {
    let layer = this.layers.get(name);
    if (!layer) {
      layer = make("g", { class: `layer ${name}` });
      if (name !== "handles") layer.setAttribute("aria-hidden", "true");
      this.svg.append(layer);
      this.layers.set(name, layer);
    }
    return layer;
  }

  clear(name: string): SVGGElement {
    const layer = this.layer(name);
    layer.replaceChildren();
    return layer;
  }

  path(points: Point[], closed = false): string {
    const words = points.map((point) => this.at(point).map((v) => v.toFixed(2)).join(" "));
    return words.length ? `M${words.join("L")}${closed ? "Z" : ""}` : "";
  }

  line(layer: string, points: Point[], kind: string, closed = false): SVGPathElement {
    const path = make("path", { d: this.path(points, closed), class: kind });
    this.layer(layer).append(path);
    return path;
  }

  /** A line that stays and is changed: for what moves with every frame. */
  moving(layer: string, name: string, kind: string): SVGPathElement {
    let path = this.kept.get(name);
    if (!path) {
      path = make("path", { class: kind });
      this.layer(layer).append(path);
      this.kept.set(name, path);
    }
    return path;
  }

  dot(layer: string, place: Point, radius: number, kind: string): SVGCircleElement {
    const [cx, cy] = this.at(place);
    const circle = make("circle", { cx, cy, r: radius, class: kind });
    this.layer(layer).append(circle);
    return circle;
  }

  words(layer: string, place: Point, text: string, kind = "label", offset: Point = [0, 0]): SVGTextElement {
    const [x, y] = this.at(place);
    const element = make("text", { x: x + offset[0], y: y + offset[1], class: kind });
    element.textContent = text;
    this.layer(layer).append(element);
    return element;
  }

  /** An arrow of so many pixels that ends at a place. */
  arrow(layer: string, to: Point, direction: Point, pixels: number, kind: string): void {
    const norm = Math.hypot(...direction) || 1;
    const [ux, uy] = [direction[0] / norm, -direction[1] / norm];
    const [x, y] = this.at(to);
    if (pixels < 2) return;
    const head = Math.min(9, 0.6 * pixels);
    const [bx, by] = [x - head * ux, y - head * uy];
    const group = make("g", { class: `arrow ${kind}` });
    group.append(
      make("line", { x1: x - pixels * ux, y1: y - pixels * uy, x2: bx, y2: by }),
      make("path", {
        d: `M${x} ${y}L${bx - 0.5 * head * uy} ${by + 0.5 * head * ux}L${bx + 0.5 * head * uy} ${by - 0.5 * head * ux}Z`,
      }),
    );
    this.layer(layer).append(group);
  }

  /** A bar that tells the scale. */
  scaleBar(metres: number): void {
    const { left, bottom } = this.box;
    const inset = 13 * this.pixel;
    const [from, to]: [Point, Point] = [[left + inset, bottom + inset], [left + inset + metres, bottom + inset]];
    this.clear("scale");
    this.line("scale", [from, to], "scale-bar");
    const words = metres < 1 ? `${Math.round(1e3 * metres)}\u202fmm` : `${metres}\u202fm`;
    this.words("scale", to, words, "scale-words", [7, 4]);
  }

  /** The map's boundaries, with what is solid filled. */
  map(outlines: Outline[]): void {
    this.clear("map");
    const arena = outlines.filter((o) => o.role === "arena").map((o) => this.path(o.points, true)).join("");
    const solid = outlines.filter((o) => o.role === "obstacle").map((o) => this.path(o.points, true)).join("");
    const walls = outlines.filter((o) => o.role === "wall").map((o) => this.path(o.points, o.closed)).join("");
    this.layer("map").append(
      make("path", { d: arena, class: "arena" }), make("path", { d: solid, class: "solid" }),
      make("path", { d: walls, class: "wall" }),
    );
  }

  /** The figure as an SVG file of its own, in the colours that are shown. What the canvas shows is given as a path. */
  picture(title: string, states?: { path: string; opacity: number }): string {
    const { width } = this;
    const height = Math.round((this.box.top - this.box.bottom) / this.pixel);
    const copy = this.svg.cloneNode(true) as SVGSVGElement;
    // Nobody takes hold of a picture.
    const handles = copy.querySelectorAll(".handles");
    // Styles are those of the page: what of them counts is written to each element.
    const shown = this.svg.querySelectorAll("*");
    copy.querySelectorAll("*").forEach((element, i) => {
      const style = getComputedStyle(shown[i]);
      const drawn = ["path", "line", "circle", "rect", "text"].includes(element.tagName);
      for (const name of [...element.getAttributeNames()]) if (/^(class|tabindex|role|aria-.*|style)$/.test(name)) element.removeAttribute(name);
      if (style.display === "none") element.setAttribute("display", "none");
      if (element.tagName === "g" && style.opacity !== "1") element.setAttribute("opacity", style.opacity);
      if (!drawn) return;
      for (const name of element.tagName === "text" ? TEXT : DRAWN) {
        const value = style.getPropertyValue(name);
        if (value && !PLAIN.has(`${name}:${value}`)) element.setAttribute(name, value.replaceAll('"', "'"));
      }
    });
    copy.querySelectorAll("[display=none]").forEach((element) => element.remove());
    handles.forEach((element) => element.remove());
    for (const name of copy.getAttributeNames()) if (name !== "viewBox") copy.removeAttribute(name);
    copy.setAttribute("xmlns", SVG);
    copy.setAttribute("width", `${width}`);
    copy.setAttribute("height", `${height}`);
    const back = make("rect", { width, height, rx: 14, fill: colour("card"), stroke: colour("faint") });
    const seen = states ? [make("path", { d: states.path, fill: colour("set"), "fill-opacity": states.opacity })] : [];
    const name = make("title", {});
    name.textContent = title;
    copy.prepend(name, back, ...seen);
    return `${new XMLSerializer().serializeToString(copy)}\n`;
  }

  /** The canvas, cleared, in pixels of the page. */
  pen(): CanvasRenderingContext2D {
    const pen = this.canvas.getContext("2d")!;
    const dense = this.canvas.width / this.width;
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.clearRect(0, 0, this.canvas.width, this.canvas.height);
    pen.setTransform(dense, 0, 0, dense, 0, 0);
    return pen;
  }
}

export function make<K extends keyof SVGElementTagNameMap>(tag: K, attributes: Attributes): SVGElementTagNameMap[K] {
  const element = document.createElementNS(SVG, tag);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, String(value));
  return element;
}

const colours = new Map<string, string>();

/** A colour of the style sheet; asked for once, since the answer takes the whole page's styles. */
export function colour(name: string): string {
  let held = colours.get(name);
  if (held === undefined) {
    held = getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
    colours.set(name, held);
  }
  return held;
}

/** After a change of dark and light. */
export function forgetColours(): void {
  colours.clear();
}

/** A way that grows: what is drawn already is left alone. */
export class Trail {
  private readonly parts: SVGPathElement[] = [];
  private words: string[] = [];
  private all: Point[] = [];

  constructor(private readonly plot: Plot, private readonly layer: string, private readonly kind: string) {}

  clear(): void {
    this.all = [];
    this.again();
  }

  /** Draws all of it anew, as after another size of the figure. */
  again(): void {
    this.parts.splice(0).forEach((part) => part.remove());
    this.words = [];
    this.all.splice(0).forEach((place) => this.add(place));
  }

  add(place: Point): void {
    const word = this.plot.at(place).map((v) => v.toFixed(1)).join(" ");
    if (word === this.words.at(-1)) return;
    this.all.push(place);
    if (!this.parts.length || this.words.length >= PART) {
      this.words = this.words.slice(-1);
      const part = make("path", { class: this.kind });
      this.plot.layer(this.layer).append(part);
      this.parts.push(part);
      if (this.parts.length > MOST_PARTS) {
        this.parts.shift()!.remove();
        this.all.splice(0, PART - 1);
      }
    }
    this.words.push(word);
    this.parts.at(-1)!.setAttribute("d", `M${this.words.join("L")}`);
  }

  show(on: boolean): void {
    this.plot.layer(this.layer).style.display = on ? "" : "none";
  }
}

export interface HandleOptions {
  /** What it is, for screen readers. */
  name: string;
  /** What it is at now, for screen readers. */
  value(): string;
  /** Moved to a place of the world, by a pointer. */
  drag(place: Point): void;
  /** Moved by arrow keys: steps to the right and up, 5 with shift. */
  nudge(right: number, up: number): void;
  release?(): void;
  kind?: string;
  /** An icon's path in a box of ±10 pixels. */
  icon?: string;
}

/** Something to take hold of: by pointer, touch and keys. */
export class Handle {
  readonly element: SVGGElement;

  constructor(private readonly plot: Plot, private readonly options: HandleOptions) {
    this.element = make("g", { class: `handle ${options.kind ?? ""}`, tabindex: 0, role: "slider", "aria-label": options.name, "aria-valuenow": 0 });
    this.element.append(
      make("circle", { class: "reach", r: 24 }), make("circle", { class: "halo", r: 15 }), make("circle", { class: "knob", r: 8 }),
    );
    if (options.icon) this.element.append(make("path", { class: "icon", d: options.icon }));
    plot.layer("handles").append(this.element);
    let grip: Point | undefined;
    this.element.addEventListener("pointerdown", (event) => {
      event.preventDefault();
      this.element.focus({ preventScroll: true });
      this.element.setPointerCapture(event.pointerId);
      const under = plot.under(event);
      grip = [this.place[0] - under[0], this.place[1] - under[1]];
      this.element.classList.add("held");
    });
    this.element.addEventListener("pointermove", (event) => {
      if (!grip) return;
      const [x, y] = plot.under(event);
      options.drag([x + grip[0], y + grip[1]]);
    });
    const let_go = () => {
      if (!grip) return;
      grip = undefined;
      this.element.classList.remove("held");
      options.release?.();
    };
    this.element.addEventListener("pointerup", let_go);
    this.element.addEventListener("pointercancel", let_go);
    this.element.addEventListener("keydown", (event) => {
      const step = event.shiftKey ? 5 : 1;
      const ways: Record<string, Point> = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
      const way = ways[event.key];
      if (!way) return;
      event.preventDefault();
      options.nudge(way[0] * step, way[1] * step);
      options.release?.();
    });
  }

  place: Point = [0, 0];

  /** Without `told` screen readers do not hear of it: for what moves with every frame. */
  moveTo(place: Point, told = true): void {
    this.place = place;
    const [x, y] = this.plot.at(place);
    this.element.setAttribute("transform", `translate(${x.toFixed(2)} ${y.toFixed(2)})`);
    if (told) this.element.setAttribute("aria-valuetext", this.options.value());
  }

  show(on: boolean): void {
    this.element.style.display = on ? "" : "none";
  }
}
