// A run as it goes on: what `vibrissa live --view` tells over its socket, and the way back in time.

import type { Estimate, Place, Point, Verdict } from "../engine";
import { button, element, Readout, slider } from "../controls";
import { Plot, boxOf } from "../plot";
import { onceAFrame, type Running, type Scene, type Stage } from "../scene";
import { drawPlaces, drawRobot, verdictWords } from "../robot";
import { Strip } from "../strip";
import { markerLines } from "../marker_array";
import * as units from "../units";

/** How many estimates one can go back, and how long to wait before the next try (ms). */
const KEPT = 20000;
const AGAIN = 1500;
const PORT = "8765";
/** Seconds of readings, of them behind the time that one goes back to; charts at most. */
const SECONDS = 8;
const AHEAD = 2;
const MOST_STRIPS = 6;
const WORDS = 100;
const TOPICS = ["lines", "estimate", "whiskers", "readings", "health"].map((name) => `/vibrissa/${name}`);

/** A line of the run, as `vibrissa live --json` prints it. */
interface Told {
  t: number;
  rows: number;
  status: Verdict;
  places: (Record<"x" | "y" | "theta" | "weight" | "x_min" | "x_max" | "y_min" | "y_max" | "theta_min" | "theta_max", number> & { covariance?: number[][] })[];
  count: number;
}

interface PoseAt {
  x: number;
  y: number;
  theta: number;
}

/** Every whisker as it bends; what a run does not tell is missing. */
interface Whiskers {
  t: number;
  pose: PoseAt | null;
  whiskers: {
    name?: string;
    length?: number;
    mount?: PoseAt;
    touching?: boolean;
    readings?: { column: string; unit: string; value: number | null; bound?: number | null; expected?: number | null }[];
    from?: "map" | "reading" | "rest";
    shape?: Point[];
    contact?: Point | null;
  }[];
}

interface Readings {
  columns: string[];
  units: string[];
  t: number[];
  values: (number | null)[][];
}

interface Health {
  rows: number;
  merged: number;
  missing: number;
  not_recorded: number;
  latency_p99: number | null;
  sources?: Record<string, string | number>[];
}

/** What was told of one time. */
interface Moment {
  told: Told;
  whiskers?: Whiskers;
  health?: Health;
}

/** How charts show a unit: its words, how much of it an SI unit is, what is shown at least. */
const CHARTS: Record<string, { words: string; scale: number; least: number }> = {
  "N m": { words: "mN\u202fm", scale: 1e3, least: 2e-3 },
  N: { words: "mN", scale: 1e3, least: 0.02 },
  rad: { words: "mrad", scale: 1e3, least: 0.02 },
  m: { words: "mm", scale: 1e3, least: 2e-3 },
};
/** Kinds of loss of a source, in words. */
const LOSSES = ["damaged", "torn", "lost", "late", "unjoined", "uncalibrated"];

export const live: Scene = {
  id: "live",
  tab: "Live",
  title: "A robot while it drives",
  lead: "Start vibrissa live --demo --view in a terminal, or your own robot with --view: its whiskers, readings and places appear here. Drag the time to go back.",
  start: (stage) => new LiveScene(stage),
};

class LiveScene implements Running {
  private port: string;
  private socket: WebSocket | undefined;
  private timer = 0;
  private ended = false;
  private readonly topics = new Map<number, string>();
  private lines: Point[][] = [];
  private linesDrawn: Point[][] | undefined;
  private readonly moments: Moment[] = [];
  private readonly strips = new Map<string, Strip>();
  /** How far back one looks: 0 is now. */
  private back = 0;
  private heard = 0;
  private worded = 0;
  private later = 0;
  private readonly plot: Plot;
  /** The whiskers in the robot's frame, which a large map would show too small. */
  private readonly near: Plot;
  private readonly charts = element("div", { class: "charts" });
  private readonly readout: Readout;
  private readonly badge = element("span", { class: "badge" });
  private readonly words = element("p", { class: "note" });
  private readonly link = element("p", { class: "note", role: "status" });
  private readonly time: { set(value: number): void };
  private readonly ask: ReturnType<typeof onceAFrame>;

  constructor(private readonly stage: Stage) {
    this.port = /^\d{1,5}$/.test(stage.state.port ?? "") ? stage.state.port : PORT;
    this.ask = onceAFrame(() => this.draw());
    this.plot = new Plot(stage.figure, { left: 0, right: 0.5, bottom: 0, top: 0.35 }, "The map, the running robot and its places", () => this.redraw());
    for (const layer of ["map", "path", "places", "robot", "empty"]) this.plot.layer(layer);
    stage.figure.append(this.charts);
    const times = element("div", { class: "timeline" });
    stage.figure.append(times);
    this.time = slider(times, "Time", { min: 0, max: 1000, step: 1 }, 1000, () => this.timeWords(), (v) => {
      this.back = v >= 1000 ? 0 : Math.round((1 - v / 1000) * Math.max(0, this.moments.length - 1));
      this.worded = 0;
      this.ask();
    });
    const buttons = element("div", { class: "buttons" });
    times.append(buttons);
    const step = (by: number) => {
      this.back = Math.min(Math.max(0, this.moments.length - 1), Math.max(0, this.back + by));
      this.time.set(this.back ? 1000 * (1 - this.back / Math.max(1, this.moments.length - 1)) : 1000);
      this.worded = 0;
      this.ask();
    };
    button(buttons, "Step back", () => step(1));
    button(buttons, "Step on", () => step(-1));
    button(buttons, "Now", () => step(-this.back));
    stage.panel.append(element("div", { class: "verdict" }, this.badge, this.words));
    this.near = new Plot(stage.panel, { left: -0.06, right: 0.06, bottom: -0.04, top: 0.04 }, "The whiskers as they bend, in the robot's frame", () => this.redraw());
    for (const layer of ["whiskers", "body", "marks"]) this.near.layer(layer);
    const id = "port";
    const input = element("input", { id, type: "text", inputmode: "numeric", value: this.port, maxlength: "5" });
    input.addEventListener("change", () => {
      this.port = /^\d{1,5}$/.test(input.value) ? input.value : PORT;
      input.value = this.port;
      this.stage.changed({ port: this.port });
      this.connect();
    });
    this.readout = new Readout(stage.panel);
    stage.panel.append(element("div", { class: "field" }, element("label", { for: id }, "Port of --view on this machine"), input), this.link);
    this.connect();
    this.draw();
  }

  redraw(): void {
    this.linesDrawn = undefined;
    this.worded = 0;
    this.ask();
  }

  end(): void {
    this.ended = true;
    clearTimeout(this.timer);
    clearTimeout(this.later);
    this.socket?.close();
    this.ask.cancel();
    this.plot.end();
    this.near.end();
    this.strips.forEach((strip) => strip.end());
  }

  private connect(): void {
    clearTimeout(this.timer);
    this.socket?.close();
    const socket = new WebSocket(`ws://127.0.0.1:${this.port}`, ["foxglove.sdk.v1", "foxglove.websocket.v1"]);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    this.link.textContent = `Waiting for a run on port ${this.port} …`;
    socket.onopen = () => {
      this.link.textContent = `Connected to 127.0.0.1:${this.port}.`;
    };
    socket.onmessage = ({ data }) => (typeof data === "string" ? this.advertised(data) : this.message(data as ArrayBuffer));
    socket.onclose = () => {
      if (this.ended || socket !== this.socket) return;
      this.link.textContent = this.moments.length ? "The run has ended; trying again." : `No run on port ${this.port} yet; trying again.`;
      this.timer = window.setTimeout(() => this.connect(), AGAIN);
    };
  }

  /** Subscribes to what the page shows. */
  private advertised(text: string): void {
    const message = JSON.parse(text) as { op: string; channels?: { id: number; topic: string }[] };
    if (message.op !== "advertise") return;
    const channels = (message.channels ?? []).filter((channel) => TOPICS.includes(channel.topic));
    channels.forEach((channel) => this.topics.set(channel.id, channel.topic));
    const subscriptions = channels.map(({ id }) => ({ id, channelId: id }));
    if (subscriptions.length) this.socket?.send(JSON.stringify({ op: "subscribe", subscriptions }));
  }

  private message(data: ArrayBuffer): void {
    const view = new DataView(data);
    if (view.byteLength < 13 || view.getUint8(0) !== 1) return;
    const topic = this.topics.get(view.getUint32(1, true));
    this.heard += 1;
    if (topic === "/vibrissa/lines") {
      this.lines = markerLines(new DataView(data, 13));
      const points = this.lines.flat();
      if (points.length) this.plot.show(boxOf(points, 0.03));
    } else if (topic) {
      this.take(topic, JSON.parse(new TextDecoder().decode(new Uint8Array(data, 13))));
    }
    this.ask();
  }

  private take(topic: string, body: unknown): void {
    const newest = this.moments.at(-1);
    if (topic === "/vibrissa/estimate") {
      const told = body as Told;
      // Another run begins anew.
      if (told.t < (newest?.told.t ?? -Infinity)) this.begin();
      if (!newest) this.linesDrawn = undefined;
      this.moments.push({ told, health: newest?.health });
      if (this.moments.length > KEPT) this.moments.splice(0, KEPT / 4);
      if (this.back) this.back = Math.min(this.back + 1, this.moments.length - 1);
    } else if (topic === "/vibrissa/whiskers") {
      const whiskers = body as Whiskers;
      if (newest) newest.whiskers = whiskers;
    } else if (topic === "/vibrissa/readings") {
      this.read(body as Readings);
    } else if (topic === "/vibrissa/health") {
      const health = body as Health;
      if (newest && health.missing > (newest.health?.missing ?? 0)) this.strips.forEach((strip) => strip.lost(newest.told.t));
      if (newest) newest.health = health;
    }
  }

  private begin(): void {
    this.moments.length = 0;
    this.back = 0;
    this.strips.forEach((strip) => strip.clear());
  }

  private read({ columns, units: of, t, values }: Readings): void {
    columns?.forEach((column, k) => {
      let strip = this.strips.get(column);
      if (!strip && this.strips.size < MOST_STRIPS) {
        const chart = CHARTS[of?.[k]] ?? { words: of?.[k] ?? "", scale: 1, least: 1e-3 };
        strip = new Strip(this.charts, SECONDS, { ...chart, words: `${column}, ${chart.words}` });
        this.strips.set(column, strip);
      }
      t?.forEach((at, i) => {
        const value = values?.[k]?.[i];
        if (strip && typeof value === "number") strip.add(at, value);
      });
    });
  }

  private shown(): Moment | undefined {
    return this.moments[Math.max(0, this.moments.length - 1 - this.back)];
  }

  private timeWords(): string {
    const shown = this.moments.length ? this.shown() : undefined;
    return shown ? `${units.quantity(shown.told.t - this.moments[0].told.t, 1, "s")}${this.back ? "" : ", now"}` : "–";
  }

  private draw(): void {
    const { plot } = this;
    if (this.linesDrawn !== this.lines) {
      this.linesDrawn = this.lines;
      ["map", "empty"].forEach((layer) => plot.clear(layer));
      const [width, height] = [plot.box.right - plot.box.left, plot.box.top - plot.box.bottom];
      plot.scaleBar(width > 4 ? 1 : width > 0.8 ? 0.1 : 0.05);
      this.lines.forEach((line) => plot.line("map", line, "arena"));
      if (!this.lines.length && !this.moments.length) {
        const at: Point = [plot.box.left + 0.5 * width, plot.box.bottom + 0.5 * height];
        plot.words("empty", at, "Nothing is heard yet", "big", [0, -6]);
        plot.words("empty", at, "vibrissa live --demo --view", "big code", [0, 18]);
      }
    }
    ["path", "places", "robot"].forEach((layer) => plot.clear(layer));
    const shown = this.shown();
    const estimate = shown && estimateOf(shown.told);
    const until = this.moments.length - this.back;
    const trail = this.moments.slice(Math.max(0, until - 1500), until).filter(({ told }) => told.places.length === 1);
    plot.line("path", trail.map(({ told }) => [told.places[0].x, told.places[0].y] as Point), "estimated");
    if (estimate) drawPlaces(plot, "places", estimate.places);
    this.drawWhiskers(shown?.whiskers);
    const at = shown && this.back ? shown.told.t : undefined;
    const newest = this.moments.at(-1)?.told.t ?? 0;
    this.strips.forEach((strip) => strip.draw(at, at === undefined ? undefined : Math.min(newest, at + AHEAD)));
    const now = performance.now();
    if (now - this.worded < WORDS) {
      clearTimeout(this.later);
      this.later = window.setTimeout(() => this.ask(), WORDS);
      return;
    }
    this.worded = now;
    this.tell(shown, estimate);
  }

  /** The whiskers on the map at the best place, and larger in the robot's own frame. */
  private drawWhiskers(told: Whiskers | undefined): void {
    const { plot, near } = this;
    const whiskers = told?.whiskers ?? [];
    near.frame.style.display = whiskers.some((w) => w.shape) ? "" : "none";
    if (!told) return;
    const reach = Math.max(0.02, ...whiskers.map((w) => Math.hypot(w.mount?.x ?? 0, w.mount?.y ?? 0) + (w.length ?? 0)));
    const box = { left: -1.25 * reach, right: 1.25 * reach, bottom: -1.1 * reach, top: 1.1 * reach };
    if (Math.abs(near.box.right - box.right) > 1e-6) near.show(box);
    ["whiskers", "body", "marks"].forEach((layer) => near.clear(layer));
    drawRobot(near, "body", [0, 0, 0], "robot");
    const { pose } = told;
    const [c, s] = pose ? [Math.cos(pose.theta), Math.sin(pose.theta)] : [1, 0];
    const placed = ([u, v]: Point): Point => [pose!.x + c * u - s * v, pose!.y + s * u + c * v];
    if (pose) drawRobot(plot, "robot", [pose.x, pose.y, pose.theta], "robot");
    for (const whisker of whiskers) {
      if (!whisker.shape) continue;
      // What the map does not hold is what the moment alone gives.
      const kind = `whisker thin${whisker.from === "reading" ? " supposed" : ""}`;
      near.line("whiskers", whisker.shape, kind);
      if (whisker.contact) near.dot("marks", whisker.contact, 4, "contact");
      else if (whisker.touching) near.dot("marks", whisker.shape.at(-1)!, 4, "contact open");
      if (whiskers.length > 1 && whisker.name) near.words("marks", whisker.shape.at(-1)!, whisker.name, "label", [6, 4]);
      if (!pose) continue;
      plot.line("robot", whisker.shape.map(placed), kind);
      if (whisker.contact) plot.dot("robot", placed(whisker.contact), 3, "contact");
    }
  }

  private tell(shown: Moment | undefined, estimate: Estimate | undefined): void {
    const { badge, kind, words } = verdictWords(estimate, shown?.told.count);
    this.badge.textContent = shown ? badge : "not connected";
    this.badge.className = `badge ${shown ? kind : ""}`;
    this.words.textContent = shown ? words : "";
    const { readout } = this;
    const health = shown?.health;
    const best = estimate?.places[0];
    readout.set("Position", best ? `${units.quantity(1e3 * best.x, 1, "")}, ${units.length(best.y)}` : "–", "main");
    readout.set("Heading", best ? units.angle(best.theta) : "–");
    for (const { name, touching, readings } of shown?.whiskers?.whiskers ?? []) {
      const [first] = readings ?? [];
      if (!first) continue;
      const chart = CHARTS[first.unit] ?? { words: first.unit, scale: 1 };
      const value = (v: number | null | undefined) => (typeof v === "number" ? units.quantity(chart.scale * v, 2, chart.words) : "–");
      readout.set(`Whisker ${name ?? ""}`.trim(), `${value(first.value)}${touching ? ", touching" : ""}`);
      if (first.expected !== undefined) readout.set(`${name ?? "Whisker"} expects`, value(first.expected));
    }
    readout.set("Places", shown ? `${shown.told.count}` : "–");
    readout.set("Rows", shown ? `${shown.told.rows}` : "–");
    const lost = LOSSES.map((loss) => [loss, (health?.sources ?? []).reduce((sum, source) => sum + Number(source[loss] ?? 0), 0)] as const);
    const which = lost.filter(([, count]) => count > 0).map(([loss, count]) => `${count} ${loss}`).join(", ");
    readout.set("Frames lost", health ? `${health.missing}${which ? ` (${which})` : ""}` : "–", health && health.missing > 0 ? "bad" : "");
    readout.set("Rows merged", health ? `${health.merged}` : "–");
    readout.set("Latency, 99\u202f%", health?.latency_p99 ? units.quantity(1e3 * health.latency_p99, 1, "ms") : "–");
    if (!this.back) this.time.set(1000);
    if (shown) this.stage.announce(this.back ? `${this.timeWords()}: ${words}` : words);
  }

  answers(): unknown {
    const shown = this.shown();
    const drawn = [...this.plot.layer("robot").querySelectorAll(".whisker")].map((path) => (path as SVGPathElement).getPointAtLength(1e9));
    return {
      connected: this.socket?.readyState === WebSocket.OPEN, heard: this.heard, lines: this.lines.length, told: this.moments.length,
      last: this.moments.at(-1)?.told, health: this.moments.at(-1)?.health, shown: shown?.told.t,
      charts: [...this.strips.keys()], gaps: [...this.strips.values()].map((strip) => strip.gaps()),
      tips: drawn.map(({ x, y }) => [this.plot.box.left + x * this.plot.pixel, this.plot.box.top - y * this.plot.pixel]),
    };
  }
}

function estimateOf(told: Told): Estimate {
  const place = (p: Told["places"][number]): Place => ({
    x: p.x, y: p.y, theta: p.theta, weight: p.weight,
    extent: [p.x_min, p.x_max, p.y_min, p.y_max, p.theta_min, p.theta_max],
    position: p.covariance ? Math.sqrt(p.covariance[0][0] + p.covariance[1][1]) : NaN,
    heading: p.covariance ? Math.sqrt(p.covariance[2][2]) : NaN,
  });
  return { verdict: told.status, rows: told.rows, places: told.places.map(place), states: new Float64Array() };
}
