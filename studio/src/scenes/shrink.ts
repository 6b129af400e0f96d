// Drive a robot through a room: its whisker bends, and the set of places that explain the readings shrinks.

import type { Driven, Estimate, Point, RoomMap } from "../engine";
import { button, choice, element, Readout, save, toggle } from "../controls";
import { Handle, Plot, Trail } from "../plot";
import { onceAFrame, still, type Running, type Scene, type Stage, type State } from "../scene";
import type { Remote } from "../remote";
import { Backlog } from "../backlog";
import { MOUNT, ROOMS, drawnRoom, robotFile, roomBox, roomOf, type Pose, type Room } from "../rooms";
import { read, written, type Knot } from "../drive_link";
import { carried, clearOf, drawPlaces, drawStates, outline, statesPath, verdictWords } from "../robot";
import { Strip } from "../strip";
import * as units from "../units";

/** Rows a second, speed (m/s) and turning rate (rad/s) by hand and by itself. */
const RATE = 150;
const SPEED = 0.14;
const TURN = 1.8;
const OWN_SPEED = 0.06;
/** What the switches add: offset (N m), gain and slip (relative). */
const OFFSET = 3e-4;
const GAIN = 0.15;
const SLIP = 0.06;
/** Words and numbers change no more often than they can be read (ms). */
const WORDS = 100;
const CHART = 45;
const NOTHING = { states: new Float64Array(), places: [] };
/** An estimate older than so many rows is carried on by the wheels and told to be so; estimates come some rows apart anyway. */
const LATE = 15;
/** What is carried on is drawn anew so often (ms). */
const CARRY = 50;
/** Poses of the drive that the link carries come so far apart (s), and the link is written anew after so many. */
const KNOTS = 0.1;
const LINKED = 10;
/** How many times of frames and slices are kept. */
const TIMES = 20000;
const KEYS: Record<string, [number, number]> = {
  ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowLeft: [0, 1], ArrowRight: [0, -1],
  w: [1, 0], s: [-1, 0], a: [0, 1], d: [0, -1],
};

export const METHODS = [
  { value: "probabilistic", words: "probabilistic", hint: "Least squares at every place that fits, with weights" },
  { value: "possibilistic", words: "possibilistic", hint: "Guaranteed: what is outside is ruled out" },
  { value: "deterministic", words: "deterministic", hint: "The paper's intersection of preimages" },
];

export const shrink: Scene = {
  id: "shrink",
  tab: "Shrinking set",
  title: "Drive, feel, and know where you are",
  lead: "The blue dots are all places that explain what the whisker has felt. Drag the robot along the walls, or use the arrow keys: rivals die, the set shrinks.",
  start: async (stage) => {
    const scene = new ShrinkScene(stage);
    await scene.open();
    return scene;
  },
};

/** A method beside others on the same drive. */
interface Judge {
  method: string;
  worker: Remote;
  estimate?: Estimate;
  backlog: Backlog;
  failed: string;
}

class ShrinkScene implements Running {
  private room: Room;
  private method: string;
  private readonly errors = { offset: false, gain: false, slip: false, declared: false };
  private hidden = false;
  private map: RoomMap = { outlines: [], warnings: [] };
  private pose: Pose = [0, 0, 0];
  private drawn: Pose = [0, 0, 0];
  private t = 0;
  private due = 0;
  private target: Point | undefined;
  private readonly pressed = new Set<string>();
  private own: { way: Pose[]; at: number; done: boolean } | undefined;
  /** A drive of the link that is driven again, and the drive so far for the next link. */
  private again: { knots: Knot[]; at: number } | undefined;
  private knots: Knot[] = [];
  private taken = false;
  private driven: Driven | undefined;
  private rows: number[] = [];
  private readonly trail: Trail;
  /** The method that is shown, or all of them. */
  private judges: Judge[] = [];
  private all = false;
  private readonly times = { frames: [] as number[], work: [] as number[], slices: [] as number[], estimates: [] as number[] };
  private busy = false;
  private queue: number[] = [];
  private generation = 0;
  /** The estimate that is drawn, and when words were told last (ms). */
  private painted: Pick<Estimate, "states" | "places"> | undefined;
  /** From which one that is carried on, and when (ms). */
  private carried: { from?: Estimate; at: number } = { at: 0 };
  private told = 0;
  private charted = 0;
  private later = 0;
  /** What was drawn since the last frame took so long (ms). */
  private spent = 0;
  private loop = 0;
  private last = 0;
  private readonly driver: Remote;
  private readonly plot: Plot;
  private readonly handle: Handle;
  private readonly strip: Strip;
  private readonly readout: Readout;
  private readonly badge: HTMLElement;
  private readonly words: HTMLElement;
  private readonly table = element("table", { class: "compare" });
  private readonly ask: ReturnType<typeof onceAFrame>;

  constructor(private readonly stage: Stage) {
    const { state } = stage;
    this.room = drawnRoom(state.ring ?? "") ?? roomOf(state.room);
    this.all = state.all === "1";
    this.method = METHODS.find((m) => m.value === state.method)?.value ?? "probabilistic";
    for (const key of ["offset", "gain", "slip", "declared"] as const) this.errors[key] = state[key] === "1";
    this.driver = stage.worker();
    this.ask = onceAFrame(() => this.draw());
    this.plot = new Plot(stage.figure, { left: 0, right: 0.5, bottom: 0, top: 0.35 }, "A room, the robot, and the places where it may be", () => this.fit());
    for (const layer of ["map", "trail", "robot", "places", "marks", "handles"]) this.plot.layer(layer);
    this.trail = new Trail(this.plot, "trail", "way");
    this.handle = new Handle(this.plot, {
      name: "The robot: drag it, or drive with the arrow keys", kind: "push robot-handle",
      value: () => `at ${units.length(this.drawn[0], 0)}, ${units.length(this.drawn[1], 0)}, heading ${units.angle(this.drawn[2])}`,
      drag: (place) => {
        this.take();
        this.target = place;
      },
      nudge: () => undefined,
      release: () => (this.target = undefined),
    });
    this.plot.frame.addEventListener("keydown", (event) => this.key(event, true), true);
    this.plot.frame.addEventListener("keyup", (event) => this.key(event, false), true);
    this.plot.frame.addEventListener("focusout", () => this.pressed.clear());
    this.strip = new Strip(stage.figure, 8);
    this.badge = element("span", { class: "badge" });
    this.words = element("p", { class: "note" });
    stage.panel.append(element("div", { class: "verdict" }, this.badge, this.words));
    const drawn = this.room.id === "drawn" ? [this.room] : [];
    choice(stage.panel, "Room", [...drawn, ...ROOMS].map((r) => ({ value: r.id, words: r.words })), this.room.id, (id) => {
      this.room = drawn.find((r) => r.id === id) ?? roomOf(id);
      void this.open();
    });
    choice(stage.panel, "Method", METHODS, this.method, (method) => {
      this.method = method;
      if (this.shown()) {
        this.keep();
        this.told = 0;
        this.ask();
      } else void this.judge();
    });
    toggle(stage.panel, "All methods side by side", this.all, (on) => {
      this.all = on;
      void this.judge();
    }, "on this one drive; the method above is the one that is drawn");
    stage.panel.append(this.table);
    const group = element("div", { class: "group" }, element("span", { class: "title" }, "Make it hard"));
    stage.panel.append(group);
    const error = (key: "offset" | "gain" | "slip", title: string, hint: string) =>
      toggle(group, title, this.errors[key], (on) => {
        this.errors[key] = on;
        this.keep();
      }, hint);
    error("offset", "Sensor offset", `every reading is ${units.moment(OFFSET)} too large`);
    error("gain", "Sensor gain", `every reading is ${100 * GAIN}\u202f% too large`);
    error("slip", "Wheel slip", `the wheels count ${100 * SLIP}\u202f% too much way`);
    toggle(group, "Declare such errors", this.errors.declared, (on) => {
      this.errors.declared = on;
      this.keep();
      void this.judge();
    }, "the robot file bounds them, and the method allows for them");
    toggle(group, "Hide the true robot", false, (on) => {
      this.hidden = on;
      this.ask();
    });
    this.readout = new Readout(stage.panel);
    const buttons = element("div", { class: "buttons" });
    stage.panel.append(buttons);
    button(buttons, "Start again", () => {
      delete stage.state.drive;
      void this.open();
    });
    button(buttons, "Save picture", () => save("drive.svg", this.picture(), "image/svg+xml"));
    button(buttons, "Save log", () => void this.driver.call("write", "log").then((log) => save("log.csv", log, "text/csv")));
    button(buttons, "Save map", () => save(this.room.file, this.room.map));
    button(buttons, "Save robot", () => save("robot.toml", robotFile(this.errors.declared)));
  }

  /** Begins in the room, at its start. */
  async open(): Promise<void> {
    const generation = ++this.generation;
    cancelAnimationFrame(this.loop);
    const { driver, room } = this;
    this.map = await driver.call("readMap", room.file, room.map);
    await driver.call("readRobot", "robot.toml", robotFile(false));
    if (generation !== this.generation) return;
    this.plot.show(roomBox(this.map));
    this.pose = this.drawn = room.start;
    this.rows = [];
    this.trail.clear();
    this.queue = [];
    this.t = 0;
    this.due = 0;
    this.target = undefined;
    this.busy = false;
    const knots = read(this.stage.state.drive ?? "");
    delete this.stage.state.drive;
    this.again = knots.length > 1 ? { knots, at: knots[0][0] } : undefined;
    this.own = this.again || still() || room.way.length < 2 ? undefined : { way: room.way, at: 0, done: false };
    this.knots = [[0, ...room.start]];
    this.taken = !!this.again;
    this.strip.clear();
    this.take_in(await driver.call("startDrive", 0, room.start, 1, true));
    await this.judge();
    this.fit();
    this.keep();
    this.last = performance.now();
    this.loop = requestAnimationFrame((now) => this.frame(now));
  }

  end(): void {
    this.generation += 1;
    cancelAnimationFrame(this.loop);
    clearTimeout(this.later);
    this.ask.cancel();
    this.plot.end();
    this.strip.end();
  }

  private shown(): Judge | undefined {
    return this.judges.find((one) => one.method === this.method);
  }

  /** Judges all rows so far anew, each method in a worker of its own: what it was at is given up. */
  private async judge(): Promise<void> {
    this.judges.forEach((one) => one.worker.end());
    const methods = this.all ? METHODS.map((m) => m.value) : [this.method];
    const rows = Float64Array.from(this.rows);
    this.judges = methods.map((method) => ({ method, worker: this.stage.worker(), backlog: new Backlog(rows.length / this.width()), failed: "" }));
    this.keep();
    await Promise.all(this.judges.map((one) => this.judgeBy(one, rows)));
    this.ask();
  }

  private async judgeBy(one: Judge, rows: Float64Array): Promise<void> {
    const { room } = this;
    // Rows that come meanwhile wait in the worker behind these calls, since a worker answers in order.
    const begun = [
      one.worker.call("readMap", room.file, room.map),
      one.worker.call("readRobot", "robot.toml", robotFile(this.errors.declared)),
      one.worker.localize(one.method, (progress) => {
        one.backlog.took(progress.taken);
        this.feed(one);
        if (one.method === this.method) {
          this.note("slices", progress.slice);
          if (progress.estimate) this.note("estimates", progress.telling);
        }
        if (progress.failed) one.failed = progress.failed;
        if (progress.estimate) {
          one.estimate = progress.estimate;
          if (one.method === this.method) this.stage.announce(verdictWords(one.estimate).words);
        }
        this.ask();
      }),
      one.worker.call("addRows", rows),
    ];
    await Promise.all(begun).catch((error: Error) => (one.failed ||= error.message));
  }

  /** Hands rows that wait to a method that is ready for them. */
  private feed({ worker, backlog }: Judge): void {
    const rows = backlog.due();
    if (rows) worker.call("addRows", rows).catch(() => undefined);
  }

  /** Numbers of a row. */
  private width(): number {
    return this.driven?.width ?? 5;
  }

  private keep(): void {
    const state: State = { room: this.room.id, method: this.method };
    if (this.room.id === "drawn") state.ring = this.stage.state.ring;
    for (const [key, on] of Object.entries({ ...this.errors, all: this.all })) if (on) state[key] = "1";
    const drive = this.taken ? written(this.knots) : undefined;
    if (drive) state.drive = drive;
    this.stage.changed(state);
  }

  private key(event: KeyboardEvent, down: boolean): void {
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    if (!(key in KEYS) || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    event.stopPropagation();
    if (!down) this.pressed.delete(key);
    else {
      this.take();
      this.pressed.add(key);
    }
  }

  /** The hand takes over from the robot's own way. */
  private take(): void {
    this.own = this.again = undefined;
    this.taken = true;
    this.stage.figure.classList.add("known");
  }

  /** What hand, keys or gamepad want: forward and turn, each -1 to 1. */
  private wish(): [number, number] {
    let [forward, turn] = [0, 0];
    for (const key of this.pressed) {
      forward += KEYS[key][0];
      turn += KEYS[key][1];
    }
    const pad = navigator.getGamepads?.().find((p) => p !== null);
    if (pad && Math.hypot(pad.axes[0], pad.axes[1]) > 0.2) {
      this.take();
      forward -= pad.axes[1];
      turn -= pad.axes[0];
    }
    if (this.target) {
      const [dx, dy] = [this.target[0] - this.pose[0], this.target[1] - this.pose[1]];
      const distance = Math.hypot(dx, dy);
      if (distance > 3e-3) {
        const off = wrap(Math.atan2(dy, dx) - this.pose[2]);
        turn += Math.max(-1, Math.min(1, 2.5 * off));
        forward += Math.max(0, Math.cos(off)) * Math.min(1, distance / 0.03);
      }
    }
    return [Math.max(-1, Math.min(1, forward)), Math.max(-1, Math.min(1, turn))];
  }

  private frame(now: number): void {
    const elapsed = Math.min(0.05, (now - this.last) / 1000);
    this.note("frames", now - this.last);
    this.last = now;
    const began = performance.now();
    this.due += elapsed;
    while (this.due >= 1 / RATE) {
      this.due -= 1 / RATE;
      this.move(1 / RATE);
    }
    this.send();
    this.note("work", this.spent + performance.now() - began);
    this.spent = 0;
    this.loop = requestAnimationFrame((next) => this.frame(next));
  }

  private move(dt: number): void {
    const before = this.pose;
    if (this.again) this.repeat(dt);
    else if (this.own) this.follow(dt);
    else {
      const [forward, turn] = this.wish();
      const theta = wrap(before[2] + turn * TURN * dt);
      const way = forward * SPEED * dt;
      this.pose = clearOf(this.map.outlines, [before[0] + way * Math.cos(theta), before[1] + way * Math.sin(theta), theta]);
    }
    if (this.pose.every((v, i) => Math.abs(v - before[i]) < 1e-7)) return;
    this.t += dt;
    const { offset, gain, slip } = this.errors;
    // The last pose moves on until it is far enough from the one before.
    const { knots } = this;
    const knot: Knot = [this.t, ...this.pose];
    if (knots.length > 1 && knot[0] - knots[knots.length - 2][0] < KNOTS + 1e-9) knots[knots.length - 1] = knot;
    else if (knots.push(knot) % LINKED === 0 && this.taken) this.keep();
    this.queue.push(this.t, ...this.pose, offset ? OFFSET : 0, gain ? GAIN : 0, slip ? SLIP : 0);
  }

  /** The drive of the link, straight from one pose to the next. */
  private repeat(dt: number): void {
    const again = this.again!;
    again.at += dt;
    const next = again.knots.findIndex(([t]) => t > again.at);
    if (next < 1) {
      this.pose = again.knots.at(-1)!.slice(1) as Pose;
      this.again = undefined;
      return;
    }
    const [a, b] = [again.knots[next - 1], again.knots[next]];
    const share = (again.at - a[0]) / (b[0] - a[0]);
    const turn = wrap(b[3] - a[3]);
    this.pose = [a[1] + share * (b[1] - a[1]), a[2] + share * (b[2] - a[2]), wrap(a[3] + share * turn)];
  }

  /** Along the room's own way, straight from one pose to the next. */
  private follow(dt: number): void {
    const own = this.own!;
    const legs = own.way.slice(1).map((to, i) => Math.hypot(to[0] - own.way[i][0], to[1] - own.way[i][1]));
    own.at += OWN_SPEED * dt;
    let rest = own.at;
    for (let i = 0; i < legs.length; i++) {
      if (rest <= legs[i]) {
        const share = rest / legs[i];
        const [a, b] = [own.way[i], own.way[i + 1]];
        const mix = (k: number) => a[k] + share * (b[k] - a[k]);
        this.pose = [mix(0), mix(1), (Math.PI / 180) * mix(2)];
        return;
      }
      rest -= legs[i];
    }
    this.own = undefined;
  }

  private send(): void {
    if (this.busy || !this.queue.length) return;
    this.busy = true;
    const generation = this.generation;
    const poses = Float64Array.from(this.queue);
    this.queue = [];
    this.driver.call("drive", poses).then((driven) => {
      if (generation !== this.generation) return;
      this.busy = false;
      this.drawn = [poses.at(-6)!, poses.at(-5)!, poses.at(-4)!];
      this.take_in(driven);
    }, (error: Error) => {
      this.judges.forEach((one) => (one.failed = error.message));
      this.busy = false;
    });
  }

  private take_in(driven: Driven): void {
    this.driven = driven;
    this.rows.push(...driven.rows);
    for (let i = 0; i < driven.rows.length; i += driven.width) this.strip.add(driven.rows[i], driven.rows[i + 4]);
    this.trail.add([this.drawn[0], this.drawn[1]]);
    if (driven.rows.length && this.rows.length > driven.rows.length) {
      this.judges.forEach((one) => {
        one.backlog.add(driven.rows, driven.width);
        this.feed(one);
      });
    }
    this.ask();
  }

  private fit(): void {
    this.plot.map(this.map.outlines);
    this.plot.scaleBar(0.05);
    this.trail.again();
    this.painted = undefined;
    this.told = 0;
    this.ask();
  }

  redraw(): void {
    this.fit();
  }

  private draw(): void {
    const began = performance.now();
    this.paint();
    this.spent += performance.now() - began;
  }

  /** How many rows ago the estimate of a method was, and the odometry then and now. */
  private age(one: Judge | undefined): { rows: number; seconds: number; then: Pose; now: Pose } | undefined {
    if (!one?.estimate) return undefined;
    const width = this.width();
    const at = (row: number) => this.rows.slice((row - 1) * width, (row - 1) * width + 4);
    const last = this.rows.length / width;
    const row = one.backlog.row(one.estimate.rows);
    if (!row) return undefined;
    const [[before, ...then], [t, ...now]] = [at(row), at(last)];
    return { rows: last - row, seconds: t - before, then: then as Pose, now: now as Pose };
  }

  /** What is drawn of the estimate: itself, or where it is late carried on by the wheels to where the robot is now. */
  private present(): Pick<Estimate, "states" | "places"> {
    const one = this.shown();
    const estimate = one?.estimate;
    if (!estimate || estimate.verdict === "inconsistent") return NOTHING;
    const age = this.age(one);
    if (!age || age.rows <= LATE) return estimate;
    const now = performance.now();
    if (this.painted && this.carried.from === estimate && now - this.carried.at < CARRY) return this.painted;
    this.carried = { from: estimate, at: now };
    return carried(estimate, age.then, age.now);
  }

  private paint(): void {
    const { plot, driven } = this;
    // States and places change with estimates, which come less often than frames.
    const shown = this.present();
    if (this.painted !== shown) {
      this.painted = shown;
      plot.frame.classList.toggle("late", shown !== NOTHING && shown !== this.shown()?.estimate);
      plot.clear("places");
      drawStates(plot, shown.states);
      drawPlaces(plot, "places", shown.places);
    }
    for (const layer of ["trail", "robot", "marks"]) plot.layer(layer).style.display = this.hidden ? "none" : "";
    driven?.shapes.forEach((shape, i) => plot.moving("robot", `whisker${i}`, "whisker thin").setAttribute("d", plot.path(shape)));
    plot.moving("robot", "body", "robot").setAttribute("d", plot.path(outline(this.drawn), true));
    plot.clear("marks");
    driven?.touches.forEach((touch) => {
      plot.arrow("marks", touch.at, touch.force, 12 + Math.min(36, 200 * Math.hypot(...touch.force)), "force");
      plot.dot("marks", touch.at, 3, "contact");
    });
    const now = performance.now();
    if (now - this.charted > CHART) {
      this.charted = now;
      this.strip.draw();
    }
    const due = now - this.told > WORDS;
    this.handle.moveTo([this.drawn[0], this.drawn[1]], due);
    if (!due) {
      // The last of a motion is told, too.
      clearTimeout(this.later);
      this.later = window.setTimeout(() => this.ask(), WORDS);
      return;
    }
    this.told = now;
    this.tell();
  }

  private tell(): void {
    const { readout } = this;
    const one = this.shown();
    const { estimate, failed = "", backlog } = one ?? {};
    const { badge, kind, words } = verdictWords(estimate);
    const age = this.age(one);
    const late = age && age.rows > LATE ? lateWords(age.seconds, !!estimate?.states.length) : "";
    this.badge.textContent = failed ? "stopped" : badge;
    this.badge.className = `badge ${failed ? "bad" : kind}`;
    this.words.textContent = failed || words + late;
    readout.set("Reading", units.moment(this.rows.at(-1) ?? 0), "main");
    const best = estimate?.places[0];
    const known = best && estimate.verdict !== "inconsistent";
    const off = this.off(one);
    readout.set("States that explain all", estimate?.states.length || estimate?.verdict === "inconsistent" ? `${estimate.states.length / 3}` : "–");
    readout.set("Nearest place is off by", units.length(off, 2));
    readout.set("Error it expects", known && Number.isFinite(best.position) ? `± ${units.length(best.position, 2)}` : "–");
    readout.set("Rows waiting", `${backlog?.behind() ?? 0}`);
    this.compare();
  }

  /** How far the nearest place is from the robot (m). */
  private off(one: Judge | undefined): number {
    const estimate = one?.estimate;
    if (!estimate?.places.length || estimate.verdict === "inconsistent") return NaN;
    const age = this.age(one);
    const { places } = age && age.rows > LATE ? carried({ ...NOTHING, places: estimate.places }, age.then, age.now) : estimate;
    return Math.min(...places.map((p) => Math.hypot(p.x - this.drawn[0], p.y - this.drawn[1])));
  }

  /** All methods on the drive so far. */
  private compare(): void {
    const head = ["Method", "Verdict", "Places", "Off"].map((words) => element("th", { scope: "col" }, words));
    const row = (one: Judge) => {
      const { method, estimate, failed } = one;
      const behind = one.backlog.behind();
      const verdict = failed ? "stopped" : verdictWords(estimate).badge;
      const cells = [verdict + (behind > 20 ? ` (${behind} rows behind)` : ""), `${estimate?.places.length ?? 0}`, units.length(this.off(one), 2)];
      return element("tr", method === this.method ? { class: "shown" } : {}, element("th", { scope: "row" }, method), ...cells.map((words) => element("td", {}, words)));
    };
    this.table.replaceChildren(...(this.all ? [element("thead", {}, element("tr", {}, ...head)), element("tbody", {}, ...this.judges.map(row))] : []));
  }

  picture(): string {
    return this.plot.picture(`A robot in the room ${this.room.words}, and the states that explain its readings`, statesPath(this.plot, this.painted?.states ?? new Float64Array()));
  }

  private note(what: "frames" | "work" | "slices" | "estimates", spent: number): void {
    this.times[what].push(spent);
    if (this.times[what].length > TIMES) this.times[what].shift();
  }

  private behind(): number {
    return Math.max(0, ...this.judges.map((one) => one.backlog.behind()));
  }

  /** How long frames, what the page does in them, and the worker's slices took (ms); cheap to ask. */
  timings(): unknown {
    return { ...this.times, rows: this.rows.length / (this.driven?.width ?? 5), done: !this.own && !this.again && !this.behind() && !this.queue.length && !this.busy };
  }

  /** The log as it stands, and the answer of the method on it. */
  async answers(): Promise<unknown> {
    const log = await this.driver.call("write", "log");
    const robot = robotFile(this.errors.declared);
    const engine = await this.stage.freshEngine();
    engine.readMap(this.room.file, this.room.map);
    engine.readRobot("robot.toml", robot);
    engine.readLog("log.csv", log);
    engine.beginLocalize(this.method);
    engine.step(1e9);
    const { states: _, trajectory, ...answer } = engine.finish();
    return {
      log, robot, map: this.room.map, file: this.room.file, method: this.method, answer, poses: trajectory.length / 4,
      driving: !!(this.own ?? this.again), waiting: this.behind(), mount: MOUNT, pose: this.drawn,
      methods: this.judges.map(({ method, estimate, backlog }) => ({ method, verdict: estimate?.verdict, rows: backlog.row(estimate?.rows ?? 0) })),
    };
  }
}

/** What to say of an estimate that is so old (s). */
function lateWords(seconds: number, drawn: boolean): string {
  const behind = ` That was ${units.quantity(seconds, 1, "s")} ago: the method is still at the readings since.`;
  return drawn ? `${behind} The pale set is carried on by the wheels.` : behind;
}

const wrap = (angle: number): number => Math.atan2(Math.sin(angle), Math.cos(angle));
