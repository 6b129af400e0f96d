// A run as it goes on: what `vibrissa live --view` tells over its socket, and the way back in time.

import type { Estimate, Place, Point, Verdict } from "../engine";
import { button, element, Readout, slider } from "../controls";
import { Plot, boxOf } from "../plot";
import { onceAFrame, type Running, type Scene, type Stage } from "../scene";
import { drawPlaces, verdictWords } from "../robot";
import * as units from "../units";

/** How long one looks back (estimates), and how long to wait before the next try (ms). */
const KEPT = 20000;
const AGAIN = 1500;
const PORT = "8765";

/** A line of the run, as `vibrissa live --json` prints it. */
interface Told {
  t: number;
  rows: number;
  status: Verdict;
  places: (Record<"x" | "y" | "theta" | "weight" | "x_min" | "x_max" | "y_min" | "y_max" | "theta_min" | "theta_max", number> & { covariance?: number[][] })[];
  count: number;
}

interface Health {
  rows: number;
  merged: number;
  missing: number;
  not_recorded: number;
  latency_p99: number | null;
}

export const live: Scene = {
  id: "live",
  tab: "Live",
  title: "A robot while it drives",
  lead: "Start vibrissa live --demo --view in a terminal, or your own robot with --view: map, places and verdict appear here. Drag the time to go back.",
  start: (stage) => new LiveScene(stage),
};

class LiveScene implements Running {
  private port: string;
  private socket: WebSocket | undefined;
  private timer = 0;
  private ended = false;
  private readonly topics = new Map<number, string>();
  private lines: Point[][] = [];
  private readonly told: Told[] = [];
  private health: Health | undefined;
  /** How far back one looks: 0 is now. */
  private back = 0;
  private heard = 0;
  private readonly plot: Plot;
  private readonly readout: Readout;
  private readonly badge = element("span", { class: "badge" });
  private readonly words = element("p", { class: "note" });
  private readonly link = element("p", { class: "note", role: "status" });
  private readonly time: { set(value: number): void };
  private readonly ask: ReturnType<typeof onceAFrame>;

  constructor(private readonly stage: Stage) {
    this.port = /^\d{1,5}$/.test(stage.state.port ?? "") ? stage.state.port : PORT;
    this.ask = onceAFrame(() => this.draw());
    this.plot = new Plot(stage.figure, { left: 0, right: 0.5, bottom: 0, top: 0.35 }, "The map and the places of the running robot", () => this.ask());
    for (const layer of ["map", "path", "places", "empty"]) this.plot.layer(layer);
    const times = element("div", { class: "timeline" });
    stage.figure.append(times);
    this.time = slider(times, "Time", { min: 0, max: 1000, step: 1 }, 1000, () => this.timeWords(), (v) => {
      this.back = v >= 1000 ? 0 : Math.round((1 - v / 1000) * (this.told.length - 1));
      this.ask();
    });
    stage.panel.append(element("div", { class: "verdict" }, this.badge, this.words));
    const id = "port";
    const input = element("input", { id, type: "text", inputmode: "numeric", value: this.port, maxlength: "5" });
    input.addEventListener("change", () => {
      this.port = /^\d{1,5}$/.test(input.value) ? input.value : PORT;
      input.value = this.port;
      this.stage.changed({ port: this.port });
      this.connect();
    });
    stage.panel.append(element("div", { class: "field" }, element("label", { for: id }, "Port of --view on this machine"), input), this.link);
    this.readout = new Readout(stage.panel);
    const buttons = element("div", { class: "buttons" });
    stage.panel.append(buttons);
    button(buttons, "Now", () => {
      this.back = 0;
      this.time.set(1000);
      this.ask();
    });
    this.connect();
    this.draw();
  }

  redraw(): void {
    this.ask();
  }

  end(): void {
    this.ended = true;
    clearTimeout(this.timer);
    this.socket?.close();
    this.ask.cancel();
    this.plot.end();
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
      this.link.textContent = this.told.length ? "The run has ended; trying again." : `No run on port ${this.port} yet; trying again.`;
      this.timer = window.setTimeout(() => this.connect(), AGAIN);
    };
  }

  /** Subscribes to what the page shows. */
  private advertised(text: string): void {
    const message = JSON.parse(text) as { op: string; channels?: { id: number; topic: string }[] };
    if (message.op !== "advertise") return;
    this.topics.clear();
    const wanted = ["/vibrissa/lines", "/vibrissa/estimate", "/vibrissa/health"];
    const channels = (message.channels ?? []).filter((channel) => wanted.includes(channel.topic));
    channels.forEach((channel) => this.topics.set(channel.id, channel.topic));
    const subscriptions = channels.map(({ id }) => ({ id, channelId: id }));
    this.socket?.send(JSON.stringify({ op: "subscribe", subscriptions }));
  }

  private message(data: ArrayBuffer): void {
    const view = new DataView(data);
    if (view.byteLength < 13 || view.getUint8(0) !== 1) return;
    const topic = this.topics.get(view.getUint32(1, true));
    const body = new Uint8Array(data, 13);
    this.heard += 1;
    if (topic === "/vibrissa/lines") {
      this.lines = markerLines(new DataView(data, 13));
      const points = this.lines.flat();
      if (points.length) this.plot.show(boxOf(points, 0.03));
    } else if (topic === "/vibrissa/estimate") {
      const told = JSON.parse(new TextDecoder().decode(body)) as Told;
      // Another run begins anew.
      if (told.t < (this.told.at(-1)?.t ?? -Infinity)) this.told.length = 0;
      this.told.push(told);
      if (this.told.length > KEPT) this.told.splice(0, KEPT / 4);
      if (this.back) this.back += 1;
    } else if (topic === "/vibrissa/health") {
      this.health = JSON.parse(new TextDecoder().decode(body)) as Health;
    }
    this.ask();
  }

  private shown(): Told | undefined {
    return this.told[Math.max(0, this.told.length - 1 - this.back)];
  }

  private timeWords(): string {
    const shown = this.told.length ? this.shown() : undefined;
    return shown ? `${units.quantity(shown.t - this.told[0].t, 1, "s")}${this.back ? "" : ", now"}` : "–";
  }

  private draw(): void {
    const { plot } = this;
    ["map", "path", "places", "empty"].forEach((layer) => plot.clear(layer));
    plot.scaleBar(0.05);
    this.lines.forEach((line) => plot.line("map", line, "arena"));
    if (!this.lines.length) plot.words("empty", [0.25, 0.175], "Nothing is heard yet: vibrissa live --demo --view", "big");
    const shown = this.shown();
    const estimate = shown && estimateOf(shown);
    const trail = this.told.slice(0, this.told.length - this.back).filter((one) => one.places.length === 1);
    plot.line("path", trail.slice(-1500).map((one) => [one.places[0].x, one.places[0].y] as Point), "estimated");
    if (estimate) drawPlaces(plot, "places", estimate.places);
    const { badge, kind, words } = verdictWords(estimate);
    this.badge.textContent = shown ? badge : "not connected";
    this.badge.className = `badge ${shown ? kind : ""}`;
    this.words.textContent = shown ? words : "";
    const { readout, health } = this;
    const best = estimate?.places[0];
    readout.set("Position", best ? `${units.quantity(1e3 * best.x, 1, "")}, ${units.length(best.y)}` : "–", "main");
    readout.set("Heading", best ? units.angle(best.theta) : "–");
    readout.set("Places", shown ? `${shown.count}` : "–");
    readout.set("Rows", shown ? `${shown.rows}` : "–");
    readout.set("Frames lost", health ? `${health.missing}` : "–", health && health.missing > 0 ? "bad" : "");
    readout.set("Rows merged", health ? `${health.merged}` : "–");
    readout.set("Latency, 99\u202f%", health?.latency_p99 ? units.quantity(1e3 * health.latency_p99, 1, "ms") : "–");
    if (!this.back) this.time.set(1000);
    if (shown) this.stage.announce(words);
  }

  answers(): unknown {
    return { connected: this.socket?.readyState === WebSocket.OPEN, heard: this.heard, lines: this.lines.length, told: this.told.length, last: this.told.at(-1), health: this.health };
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

/** The lines of a visualization_msgs/MarkerArray in CDR: the points of each marker of lines. */
function markerLines(view: DataView): Point[][] {
  // Offsets count from behind the header of four bytes.
  let at = 4;
  const align = (size: number) => (at = 4 + Math.ceil((at - 4) / size) * size);
  const u32 = () => {
    align(4);
    at += 4;
    return view.getUint32(at - 4, true);
  };
  const f64 = () => {
    align(8);
    at += 8;
    return view.getFloat64(at - 8, true);
  };
  const skip = (size: number, count: number) => {
    if (count > 0) {
      align(size);
      at += size * count;
    }
  };
  const text = () => skip(1, u32());
  const lines: Point[][] = [];
  const markers = u32();
  for (let marker = 0; marker < markers; marker++) {
    u32();
    u32();
    text(); // header: stamp, frame
    text(); // namespace
    u32(); // id
    const kind = u32();
    u32(); // action
    skip(8, 7); // pose
    skip(8, 3); // scale
    skip(4, 4); // colour
    u32();
    u32(); // lifetime
    at += 1; // frame_locked
    const points: Point[] = [];
    const count = u32();
    for (let i = 0; i < count; i++) {
      points.push([f64(), f64()]);
      f64();
    }
    skip(4, 4 * u32()); // colours
    // A strip is one line, a list has two points for each.
    if (kind === 4) lines.push(points);
    else for (let i = 0; i + 1 < points.length; i += 2) lines.push([points[i], points[i + 1]]);
    text(); // texture's resource
    u32();
    u32();
    text(); // texture's header
    text();
    skip(1, u32()); // texture
    skip(4, 2 * u32()); // its coordinates
    text();
    text(); // mesh's resource
    text();
    skip(1, u32()); // mesh's file
    at += 1; // use of its materials
  }
  return lines;
}
