// One's own map, robot and log: every method on them, on one timeline.

import type { Answer, BentWhisker, Engine, Estimate, FileKind, Point, RoomMap } from "../engine";
import { button, choice, element, Readout, save, slider, toggle } from "../controls";
import { Plot, boxOf } from "../plot";
import { onceAFrame, type Running, type Scene, type Stage } from "../scene";
import type { Remote } from "../remote";
import { ROOMS, polygon, robotFile, roomBox, type Pose } from "../rooms";
import { drawPlaces, drawRobot, drawStates, drawWhiskers, statesPath, verdictWords } from "../robot";
import { Strip } from "../strip";
import * as units from "../units";
import { METHODS } from "./shrink";

/** Snapshots on the timeline, and rows of the example a second. */
const SNAPSHOTS = 240;
const RATE = 150;
const SPEED = 0.1;

interface Judged {
  method: string;
  worker: Remote;
  snapshots: { row: number; estimate: Estimate }[];
  answer?: Answer;
  failed?: string;
  began: number;
  seconds: number;
  done: number;
}

interface Log {
  columns: string[];
  rows: Float64Array;
  width: number;
  warnings: string[];
}

export const own: Scene = {
  id: "own",
  tab: "Your own",
  title: "Your own room, robot and log",
  lead: "Drop a map, a robot file and a log anywhere on the page. All methods judge the same readings; drag the time to see what each knew when.",
  start: async (stage) => {
    const scene = new OwnScene(stage);
    await scene.open();
    return scene;
  },
};

/** What a file is by its name, as the command reads it. */
export function kindOf(name: string): FileKind {
  const extension = name.split(".").at(-1)?.toLowerCase() ?? "";
  if (["csv", "log", "mcap", "bag", "db3"].includes(extension)) return "log";
  if (extension === "toml") return "robot";
  if (extension === "tum" || extension === "txt") return "truth";
  return "map";
}

class OwnScene implements Running {
  private readonly files = new Map<FileKind, { name: string; bytes: Uint8Array }>();
  private map: RoomMap = { outlines: [], warnings: [] };
  private log: Log = { columns: [], rows: new Float64Array(), width: 5, warnings: [] };
  private truth: Float64Array = new Float64Array();
  private judged: Judged[] = [];
  /** Map, robot and log for the whiskers, and what was asked last of it. */
  private bender: Engine | undefined;
  private bent: { key: string; row: number; pose: Pose; whiskers: BentWhisker[] } | undefined;
  private shown: string;
  private row = 0;
  /** Where the time stands (of 1000), and how many places were drawn for it. */
  private value = 1000;
  private drawn = { time: -1, places: 0 };
  private generation = 0;
  private refused = "";
  private taking = false;
  private drawing: Point[] | undefined;
  /** Where the next corner comes by keyboard, and the room that was drawn last. */
  private cursor: Point = [0.3, 0.21];
  private ring: Point[] = [];
  private readonly plot: Plot;
  private readonly strip: Strip;
  private readonly time: { set(value: number): void };
  private readonly table: HTMLElement;
  private readonly list: HTMLElement;
  private readonly message: HTMLElement;
  private readonly readout: Readout;
  private readonly felt: HTMLElement;
  /** Whether what the robot file does not bound is off as on a typical robot. */
  private typical: boolean;
  private readonly drive: HTMLButtonElement;
  private readonly ask: ReturnType<typeof onceAFrame>;
  private readonly off: () => void;

  constructor(private readonly stage: Stage) {
    this.shown = METHODS.find((m) => m.value === stage.state.method)?.value ?? "probabilistic";
    this.typical = stage.state.undeclared !== "none";
    this.ask = onceAFrame(() => this.draw());
    this.plot = new Plot(stage.figure, { left: 0, right: 0.5, bottom: 0, top: 0.35 }, "The map, the path and the places", () => this.fit());
    for (const layer of ["map", "path", "robot", "places", "sketch"]) this.plot.layer(layer);
    this.plot.svg.addEventListener("click", (event) => this.corner(this.plot.under(event)));
    this.plot.frame.addEventListener("keydown", (event) => this.key(event));
    this.strip = new Strip(stage.figure, Infinity);
    const times = element("div", { class: "timeline" });
    stage.figure.append(times);
    this.time = slider(times, "Time", { min: 0, max: 1000, step: 1 }, 1000, (v) => this.timeWords(v), (v) => this.seek(v));
    this.message = element("div", { class: "messages", role: "alert" });
    this.list = element("ul", { class: "files" });
    const input = element("input", { type: "file", multiple: "", class: "unseen", id: "files", tabindex: "-1", "aria-label": "Open a map, a robot, a log" });
    input.addEventListener("change", () => void this.take([...(input.files ?? [])]));
    const open = element("div", { class: "buttons" });
    stage.panel.append(element("div", { class: "group" }, element("span", { class: "title" }, "Files"), this.list, open, input), this.message);
    button(open, "Open files …", () => input.click(), "first");
    button(open, "Draw a room", () => this.sketch());
    this.drive = button(open, "Drive in it", () => {
      location.hash = `shrink?ring=${this.ring.flat().map((v) => Math.round(1000 * v)).join("_")}`;
    });
    this.drive.hidden = true;
    choice(stage.panel, "Show", METHODS, this.shown, (method) => {
      this.shown = method;
      this.told();
      this.ask();
    });
    toggle(stage.panel, "Typical errors", this.typical, (on) => {
      this.typical = on;
      this.told();
      if (this.files.get("map")) void this.judge();
    }, "of what the robot file does not bound; off: it is exact (probabilistic)");
    this.table = element("table", { class: "compare" });
    this.felt = element("ul", { class: "felt", "aria-label": "By what was felt" });
    stage.panel.append(this.table, this.felt);
    this.readout = new Readout(stage.panel);
    const saves = element("div", { class: "buttons" });
    stage.panel.append(saves);
    button(saves, "Save figure", () => void this.write("figure", "localization.svg"));
    button(saves, "Save trajectory", () => void this.write("trajectory", "trajectory.tum"));
    button(saves, "Save map", () => void this.write("map", "map.geojson"));
    button(saves, "Save log", () => void this.write("log", "log.csv"));
    const over = (event: DragEvent) => {
      event.preventDefault();
      this.plot.frame.classList.add("over");
    };
    const leave = () => this.plot.frame.classList.remove("over");
    const drop = (event: DragEvent) => {
      event.preventDefault();
      leave();
      void this.take([...(event.dataTransfer?.files ?? [])]);
    };
    addEventListener("dragover", over);
    addEventListener("dragleave", leave);
    addEventListener("drop", drop);
    this.off = () => {
      removeEventListener("dragover", over);
      removeEventListener("dragleave", leave);
      removeEventListener("drop", drop);
    };
  }

  /** The example: the arena, swept once. */
  async open(): Promise<void> {
    const room = ROOMS[0];
    const engine = await this.stage.freshEngine();
    engine.readMap(room.file, room.map);
    engine.readRobot("robot.toml", robotFile(false));
    engine.startDrive(0, room.start, 1, true);
    const poses: number[] = [];
    const path: Pose[] = [];
    room.way.slice(1).forEach((to, i) => {
      const from = room.way[i];
      const steps = Math.ceil((RATE * Math.hypot(to[0] - from[0], to[1] - from[1])) / SPEED);
      for (let k = 1; k <= steps; k++) path.push(from.map((v, j) => v + (k / steps) * (to[j] - v)) as Pose);
    });
    path.forEach(([x, y, theta], i) => poses.push((i + 1) / RATE, x, y, (Math.PI / 180) * theta, 0, 0, 0));
    engine.drive(Float64Array.from(poses));
    const text = (content: string) => new TextEncoder().encode(content);
    const half = (a: number) => `${Math.sin(a / 2)} ${Math.cos(a / 2)}`;
    const tum = [[0, ...room.start], ...path.map(([x, y, d], i) => [(i + 1) / RATE, x, y, (Math.PI / 180) * d])]
      .map(([t, x, y, theta]) => `${t} ${x} ${y} 0 0 0 ${half(theta)}`).join("\n");
    this.files.set("map", { name: room.file, bytes: text(room.map) });
    this.files.set("robot", { name: "robot.toml", bytes: text(robotFile(false)) });
    this.files.set("log", { name: "example.csv", bytes: text(engine.write("log")) });
    this.files.set("truth", { name: "truth.tum", bytes: text(`${tum}\n`) });
    void this.judge();
  }

  redraw(): void {
    this.ask();
  }

  end(): void {
    this.generation += 1;
    this.off();
    this.ask.cancel();
    this.plot.end();
    this.strip.end();
    this.judged.forEach((one) => one.worker.end());
  }

  /** Takes files as they are dropped; one that is refused leaves all as it was. */
  private async take(files: File[]): Promise<void> {
    this.refused = "";
    this.taking = true;
    const engine = await this.stage.freshEngine();
    const read: Record<FileKind, (name: string, bytes: Uint8Array) => unknown> = {
      map: (name, bytes) => engine.readMap(name, bytes), robot: (name, bytes) => engine.readRobot(name, bytes),
      log: (name, bytes) => engine.readLog(name, bytes), truth: (name, bytes) => engine.readTruth(name, bytes),
    };
    let brought = false;
    for (const file of files) {
      const [kind, bytes] = [kindOf(file.name), new Uint8Array(await file.arrayBuffer())];
      try {
        read[kind](file.name, bytes);
        this.files.set(kind, { name: file.name, bytes });
        // A new room or log has another truth.
        if (kind !== "truth" && kind !== "robot" && !files.some((f) => kindOf(f.name) === "truth")) this.files.delete("truth");
        brought = true;
      } catch (error) {
        this.refused = error instanceof Error ? error.message : String(error);
      }
    }
    this.taking = false;
    if (files.some((file) => kindOf(file.name) === "map" && file.name !== "drawn.geojson")) this.drive.hidden = true;
    if (brought) await this.judge();
    this.tell();
  }

  /** What the link carries. */
  private told(): void {
    this.stage.changed({ method: this.shown, undeclared: this.typical ? "typical" : "none" });
  }

  /** Every method on the files, one after the other. */
  private async judge(): Promise<void> {
    const generation = ++this.generation;
    this.judged.forEach((one) => one.worker.end());
    this.judged = [];
    const engine = await this.stage.freshEngine();
    [this.bender, this.bent] = [engine, undefined];
    const file = (kind: FileKind) => this.files.get(kind);
    this.map = engine.readMap(file("map")!.name, file("map")!.bytes);
    const robot = file("robot");
    engine.readRobot(robot?.name, robot?.bytes);
    const log = file("log");
    this.log = log ? engine.readLog(log.name, log.bytes) : { columns: [], rows: new Float64Array(), width: 5, warnings: [] };
    const truth = file("truth");
    this.truth = truth ? engine.readTruth(truth.name, truth.bytes) : new Float64Array();
    this.row = this.count();
    const times: number[] = [];
    const values: number[] = [];
    for (let i = 0; i < this.log.rows.length; i += this.log.width) {
      times.push(this.log.rows[i]);
      values.push(this.log.rows[i + 4]);
    }
    this.strip.set(times, values);
    this.plot.show(this.map.outlines.length ? roomBox(this.map) : boxOf([[0, 0], [1, 0.7]], 0));
    this.fit();
    this.time.set(1000);
    this.value = 1000;
    const order = [this.shown, ...METHODS.map((m) => m.value).filter((m) => m !== this.shown)];
    this.judged = order.map((method) => ({ method, worker: this.stage.worker(), snapshots: [], began: 0, seconds: 0, done: 0 }));
    for (const one of this.judged) {
      if (generation !== this.generation || !log) return;
      await this.run(one);
      this.ask();
    }
  }

  private async run(one: Judged): Promise<void> {
    const { worker } = one;
    try {
      for (const [kind, call] of [["map", "readMap"], ["robot", "readRobot"], ["log", "readLog"], ["truth", "readTruth"]] as const) {
        const file = this.files.get(kind);
        if (file) await worker.call(call, file.name, file.bytes);
      }
      one.began = performance.now();
      const every = Math.max(1, Math.floor(this.count() / SNAPSHOTS));
      await new Promise<void>((done, failed) => {
        const method = one.method === "probabilistic" ? `${one.method} undeclared=${this.typical ? "typical" : "none"}` : one.method;
        worker.localize(method, (progress) => {
          one.done = progress.taken / Math.max(1, progress.all);
          if (progress.estimate) one.snapshots.push({ row: progress.taken, estimate: progress.estimate });
          this.ask();
          if (progress.failed) failed(new Error(progress.failed));
          else if (progress.taken === progress.all) done();
        }, every).catch(failed);
      });
      one.answer = await worker.call("finish");
    } catch (error) {
      one.failed = error instanceof Error ? error.message : String(error);
    }
    one.seconds = (performance.now() - one.began) / 1000;
  }

  private count(): number {
    return this.log.rows.length / this.log.width;
  }

  private seek(value: number): void {
    this.value = value;
    this.row = Math.round((value / 1000) * this.count());
    this.ask();
  }

  private timeWords(value: number): string {
    const row = Math.min(this.count() - 1, Math.round((value / 1000) * this.count()));
    return row >= 0 && this.count() ? units.quantity(this.log.rows[row * this.log.width], 2, "s") : "–";
  }

  private async write(what: "figure" | "trajectory" | "map" | "log", name: string): Promise<void> {
    const one = this.judged.find((j) => j.method === this.shown) ?? this.judged[0];
    try {
      save(name, await one.worker.call("write", what, `${this.files.get("log")?.name} on ${this.files.get("map")?.name}`));
    } catch (error) {
      this.refused = error instanceof Error ? error.message : String(error);
      this.tell();
    }
  }

  /** Begins a room that is drawn corner by corner, on a sheet of 600 by 420 mm. */
  private sketch(): void {
    this.drawing = [];
    this.generation += 1;
    this.map = { outlines: [], warnings: [] };
    this.log = { columns: [], rows: new Float64Array(), width: 5, warnings: [] };
    this.truth = new Float64Array();
    this.bender = undefined;
    this.strip.set([], []);
    this.judged.forEach((one) => one.worker.end());
    this.judged = [];
    this.plot.show({ left: 0, right: 0.6, bottom: 0, top: 0.42 });
    this.plot.frame.tabIndex = 0;
    this.plot.frame.setAttribute("role", "application");
    this.plot.frame.setAttribute("aria-label", "A sheet to draw a room on: arrow keys move, Enter sets a corner, C closes the room");
    this.plot.frame.focus();
    this.fit();
  }

  /** Corners by keyboard: arrows move by 10 mm, with Shift by 50 mm. */
  private key(event: KeyboardEvent): void {
    if (!this.drawing || event.ctrlKey || event.metaKey || event.altKey) return;
    const moves: Record<string, Point> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    const move = moves[event.key];
    if (move) {
      const step = event.shiftKey ? 0.05 : 0.01;
      const within = (v: number, most: number) => Math.max(0, Math.min(most, Math.round(1000 * v) / 1000));
      this.cursor = [within(this.cursor[0] + step * move[0], 0.6), within(this.cursor[1] + step * move[1], 0.42)];
      this.stage.announce(`${units.length(this.cursor[0], 0)}, ${units.length(this.cursor[1], 0)}`);
    } else if (event.key === "Enter" || event.key === " ") this.corner(this.cursor);
    else if (event.key === "Backspace") this.drawing.pop();
    else if (event.key.toLowerCase() === "c" && this.drawing.length > 2) void this.close();
    else return;
    event.preventDefault();
    this.ask();
  }

  private corner(at: Point): void {
    if (!this.drawing) return;
    const snap = (v: number) => Math.round(v / 5e-3) * 5e-3;
    const place = at.map(snap) as Point;
    const [first] = this.drawing;
    if (first && this.drawing.length > 2 && Math.hypot(first[0] - place[0], first[1] - place[1]) < 14 * this.plot.pixel) void this.close();
    else this.drawing.push(place);
    this.ask();
  }

  private async close(): Promise<void> {
    const ring = this.drawing!;
    this.drawing = undefined;
    this.ring = ring;
    this.drive.hidden = false;
    this.plot.frame.removeAttribute("tabindex");
    this.plot.frame.removeAttribute("role");
    this.plot.frame.removeAttribute("aria-label");
    this.drive.focus();
    this.files.delete("log");
    this.files.delete("truth");
    await this.take([new File([polygon(ring)], "drawn.geojson")]);
  }

  private fit(): void {
    this.plot.map(this.map.outlines);
    const width = this.plot.box.right - this.plot.box.left;
    this.plot.scaleBar(width > 2 ? 0.5 : width > 0.8 ? 0.1 : 0.05);
    this.ask();
  }

  private now(): Judged | undefined {
    return this.judged.find((one) => one.method === this.shown);
  }

  /** The whiskers at the row of an estimate, where its best place is. */
  private whiskers(estimate: Estimate | undefined): BentWhisker[] {
    const [best] = estimate && estimate.verdict !== "inconsistent" ? estimate.places : [];
    if (!best || !this.bender || !this.count()) return [];
    const row = Math.min(this.count(), Math.max(1, estimate!.rows)) - 1;
    const pose: Pose = [best.x, best.y, best.theta];
    const key = `${this.generation} ${row} ${pose}`;
    if (this.bent?.key !== key) this.bent = { key, row, pose, whiskers: this.bender.whiskers(row, ...pose) };
    return this.bent.whiskers;
  }

  /** What the shown method knew at the time. */
  private known(): Estimate | undefined {
    const one = this.now();
    if (!one) return undefined;
    // The states of the last row are those before the work of the end.
    if (one.answer && this.row >= this.count()) return one.answer;
    let best: Estimate | undefined;
    for (const snapshot of one.snapshots) if (snapshot.row <= Math.max(1, this.row)) best = snapshot.estimate;
    return best;
  }

  /** The row that is shown: where the method has not come to the time that was asked for, the one that it has come to. */
  private reached(): number {
    const one = this.now();
    if (!one || one.answer || one.failed) return this.row;
    return Math.min(this.row, one.snapshots.at(-1)?.row ?? 0);
  }

  private draw(): void {
    const { plot } = this;
    ["path", "places", "robot", "sketch"].forEach((layer) => plot.clear(layer));
    const estimate = this.known();
    const row = this.reached();
    drawStates(plot, estimate && estimate.verdict !== "inconsistent" ? estimate.states : new Float64Array());
    const t = this.log.rows[Math.min(this.count() - 1, row) * this.log.width] ?? 0;
    const until = (poses: Float64Array): Point[] => {
      const points: Point[] = [];
      for (let i = 0; i < poses.length && poses[i] <= t + 1e-9; i += 4) points.push([poses[i + 1], poses[i + 2]]);
      return points;
    };
    plot.line("path", until(this.truth), "way");
    const answer = this.now()?.answer;
    if (answer && answer.verdict !== "inconsistent") plot.line("path", until(answer.trajectory), "estimated");
    if (estimate && estimate.verdict !== "inconsistent") drawPlaces(plot, "places", estimate.places);
    const whiskers = this.whiskers(estimate);
    if (!whiskers.length) this.bent = undefined;
    drawWhiskers(plot, "robot", whiskers);
    this.drawn = { time: this.value, places: estimate && estimate.verdict !== "inconsistent" ? estimate.places.length : 0 };
    const at = this.poseAt(this.truth, t);
    if (at) drawRobot(plot, "robot", at, "robot");
    if (this.drawing) {
      const [x, y] = this.cursor;
      plot.line("sketch", [[x - 0.012, y], [x + 0.012, y]], "tangent");
      plot.line("sketch", [[x, y - 0.012], [x, y + 0.012]], "tangent");
      plot.line("sketch", this.drawing, "sketched");
      this.drawing.forEach((p, i) => plot.dot("sketch", p, i === 0 ? 7 : 4, "contact"));
      if (!this.drawing.length) plot.words("sketch", [0.3, 0.24], "Click the corners, or arrow keys and Enter; the first again, or C, closes the room", "big");
    }
    this.strip.draw(this.count() ? t : undefined);
    this.tell();
  }

  private poseAt(poses: Float64Array, t: number): Pose | undefined {
    let found: Pose | undefined;
    for (let i = 0; i < poses.length && poses[i] <= t + 1e-9; i += 4) found = [poses[i + 1], poses[i + 2], poses[i + 3]];
    return found;
  }

  private tell(): void {
    const names = { map: "Map", robot: "Robot", log: "Log", truth: "Truth" };
    this.list.replaceChildren(...(Object.keys(names) as (keyof typeof names)[]).map((kind) =>
      element("li", {}, element("b", {}, names[kind]), ` ${this.files.get(kind)?.name ?? (kind === "robot" ? "the paper's whisker" : "–")}`)));
    const warnings = [...this.map.warnings, ...this.log.warnings];
    const boxes = [...(this.refused ? [[this.refused, "refused"]] : []), ...warnings.map((w) => [w, "note"])];
    const text = JSON.stringify(boxes);
    if (this.message.dataset.text !== text) {
      this.message.dataset.text = text;
      this.message.replaceChildren(...boxes.map(([words, kind]) => element("p", { class: kind }, words)));
    }
    const head = element("tr", {}, ...["Method", "Verdict", "Off", "Time"].map((w) => element("th", { scope: "col" }, w)));
    const end = this.truth.length ? [...this.truth.slice(-3)] : undefined;
    const rows = METHODS.map(({ value }) => {
      const one = this.judged.find((j) => j.method === value);
      const verdict = one?.failed ? "refused" : one?.answer ? verdictWords(one.answer).badge : one?.done ? `${Math.round(100 * one.done)}\u202f%` : "…";
      const [best] = one?.answer?.places ?? [];
      const off = best && end && one?.answer?.verdict !== "inconsistent" ? units.length(Math.hypot(best.x - end[0], best.y - end[1]), 2) : "–";
      const cells = [value, verdict, off, one?.answer ? units.quantity(one.seconds, 2, "s") : "–"];
      return element("tr", value === this.shown ? { class: "shown" } : {}, ...cells.map((w, i) => element(i ? "td" : "th", i ? {} : { scope: "row" }, w)));
    });
    this.table.replaceChildren(element("thead", {}, head), element("tbody", {}, ...rows));
    const off = this.now()?.answer?.words.nuisances.filter((n) => n.significant).map((n) => n.words) ?? [];
    if (this.felt.dataset.text !== off.join()) {
      this.felt.dataset.text = off.join();
      this.felt.replaceChildren(...off.map((words) => element("li", {}, words)));
    }
    const estimate = this.known();
    const failed = this.now()?.failed;
    const row = Math.min(this.reached(), this.count());
    const working = !failed && row < Math.min(this.row, this.count());
    const words = working && !estimate ? "The first readings are being worked on." : verdictWords(estimate).words;
    this.readout.set("Known then", failed ?? (this.count() ? words : "no log yet"));
    this.readout.set("Rows", `${row} of ${this.count()}${working ? ", working" : ""}`);
    if (estimate) this.stage.announce(words);
  }

  picture(): string {
    const estimate = this.known();
    return this.plot.picture("A map, the path of the robot and its places", statesPath(this.plot, estimate?.states ?? new Float64Array()));
  }

  answers(): unknown {
    const text = (kind: FileKind) => new TextDecoder().decode(this.files.get(kind)?.bytes);
    return {
      ready: !this.taking && this.judged.length === METHODS.length && this.judged.every((one) => one.answer || one.failed),
      refused: this.refused,
      shown: this.drawn,
      bent: this.bent && { row: this.bent.row, pose: this.bent.pose, whiskers: this.bent.whiskers },
      map: text("map"), file: this.files.get("map")?.name, logFile: this.files.get("log")?.name, robot: text("robot"), log: text("log"),
      answers: this.judged.map((one) => ({ method: one.method, failed: one.failed, seconds: one.seconds, verdict: one.answer?.verdict, places: one.answer?.places, nuisances: one.answer?.words.nuisances })),
      felt: [...this.felt.children].map((item) => item.textContent),
    };
  }
}
