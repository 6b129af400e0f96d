// One whisker: a force, a post or a wall against it, every equilibrium, the moment at its base, and the snap.

import type { Bend, Driven, Engine, Point } from "../engine";
import { choice, Readout, saving } from "../controls";
import { Handle, Plot, make } from "../plot";
import { number, still, type Running, type Scene, type Stage } from "../scene";
import * as units from "../units";

type Mode = "post" | "wall" | "force";

/** The whisker's length (m), how much arrow (m) is a newton, the largest force (N). */
const LENGTH = 0.075;
const ARROW = 0.11;
const MOST_FORCE = 0.35;
/** Nitinol's limit of strain: beyond it the whisker stays bent. */
const STRAIN_LIMIT = 0.08;
const MOVE = "M-4 0H4M0 -4V4";
/** The way of a wall in one step of the simulation (m, rad), how near it may come to the base (m), where its turning handle is (m). */
const STEP = 1e-3;
const TURN = 0.02;
const NEAREST = 6e-3;
const ARM = 0.022;
/** The free side of a wall along x, as a map. */
const HALF = JSON.stringify({
  type: "FeatureCollection",
  features: [{
    type: "Feature", properties: { role: "arena" },
    geometry: { type: "Polygon", coordinates: [[[-1, -1], [1, -1], [1, 0], [-1, 0], [-1, -1]]] },
  }],
});

export const bend: Scene = {
  id: "bend",
  tab: "Bend",
  title: "Bend a whisker",
  lead: "A whisker is a thin wire. Whatever it touches, its base feels one number: the bending moment. Drag what pushes it.",
  start: async (stage) => new BendScene(stage, await stage.freshEngine()),
};

class BendScene implements Running {
  private mode: Mode;
  private post: Point;
  private force: number;
  private arc: number;
  /** Which way the post pushes: it passes a straight whisker and takes hold from the other side. */
  private side = 1;
  private held: Bend | undefined;
  private others: Bend[] = [];
  private readonly plot: Plot;
  private readonly readout: Readout;
  private readonly handle: Handle;
  private readonly along: Handle;
  private readonly note: HTMLElement;
  private swing = 0;
  private ghost: Point[] = [];
  /** A wall by a point on it and its direction, as it is and as it was simulated last. */
  private wall: [number, number, number];
  private was: [number, number, number] | undefined;
  private driven: Driven | undefined;
  private event = "";
  private readonly turn: Handle;

  constructor(private readonly stage: Stage, private readonly simulator: Engine) {
    const { state } = stage;
    this.mode = (["post", "wall", "force"] as const).find((mode) => mode === state.mode) ?? "post";
    this.wall = [number(state, "wx", 0.045), number(state, "wy", 0.012), number(state, "wa", -0.6)];
    this.post = [number(state, "x", 0.056), number(state, "y", 0.024)];
    this.force = number(state, "f", 0.12);
    this.arc = number(state, "s", 0.06);
    this.side = this.post[1] < 0 ? -1 : 1;
    stage.engine.readRobot();
    this.plot = new Plot(stage.figure, { left: -0.014, right: 0.092, bottom: -0.034, top: 0.04 }, "A whisker and what pushes it", () => this.draw());
    for (const layer of ["rest", "wall", "others", "whisker", "marks", "handles"]) this.plot.layer(layer);
    choice(stage.panel, "Push with", [
      { value: "post", words: "a post", hint: "The contact point is known" },
      { value: "wall", words: "a wall", hint: "As a robot that drives along it" },
      { value: "force", words: "a force", hint: "Force and place are known" },
    ], this.mode, (mode) => this.change(mode));
    this.readout = new Readout(stage.panel);
    this.note = document.createElement("p");
    this.note.className = "note";
    stage.panel.append(this.note);
    saving(stage.panel, "whisker.svg", () => this.picture());
    this.handle = new Handle(this.plot, {
      name: "What pushes the whisker", icon: MOVE, kind: "push",
      value: () => (this.mode === "post"
        ? `post at ${units.length(this.post[0])} along, ${units.length(this.post[1])} across`
        : this.mode === "wall"
        ? `wall through ${units.length(this.wall[0])} along, ${units.length(this.wall[1])} across`
        : `force ${units.force(this.force)}`),
      drag: (place) => ({ post: () => this.movePost(place), wall: () => this.moveWall([place[0], place[1], this.wall[2]]), force: () => this.pull(place) })[this.mode](),
      nudge: (right, up) => (this.mode === "post"
        ? this.movePost([this.post[0] + 1e-3 * right, this.post[1] + 1e-3 * up])
        : this.mode === "wall"
        ? this.moveWall([this.wall[0] + 1e-3 * right, this.wall[1] + 1e-3 * up, this.wall[2]])
        : this.setForce(this.force + 0.005 * (right + up))),
    });
    this.along = new Handle(this.plot, {
      name: "Where the force acts", kind: "small",
      value: () => `${units.length(this.arc)} from the base along the whisker`,
      drag: (place) => this.slide(place),
      nudge: (right, up) => this.setArc(this.arc + 1e-3 * (right + up)),
    });
    this.turn = new Handle(this.plot, {
      name: "The wall's direction", kind: "small",
      value: () => units.angle(this.wall[2]),
      drag: ([x, y]) => this.moveWall([this.wall[0], this.wall[1], Math.atan2(y - this.wall[1], x - this.wall[0])]),
      nudge: (right, up) => this.moveWall([this.wall[0], this.wall[1], this.wall[2] + 0.02 * (right + up)]),
    });
    this.solve();
  }

  picture(): string {
    return this.plot.picture(`A whisker that ${this.mode === "force" ? "a force" : `a ${this.mode}`} bends, and the moment at its base`);
  }

  redraw(): void {
    this.draw();
  }

  end(): void {
    cancelAnimationFrame(this.swing);
    this.plot.end();
  }

  private change(mode: Mode): void {
    if (mode === "force" && this.held) {
      this.force = Math.max(-MOST_FORCE, Math.min(MOST_FORCE, this.held.force));
      this.arc = this.held.s_a;
    }
    if (mode === "post" && this.held) {
      this.post = [this.held.x, this.held.y];
      this.side = this.held.force < 0 ? -1 : 1;
    }
    this.mode = mode;
    this.held = undefined;
    this.was = undefined;
    this.solve();
  }

  private moveWall([x, y, a]: [number, number, number]): void {
    const { left, right, bottom, top } = this.plot.box;
    const turned = Math.max(-1.5, Math.min(1.5, a));
    const place: Point = [Math.min(right - 6e-3, Math.max(left + 6e-3, x)), Math.min(top - 4e-3, Math.max(bottom + 4e-3, y))];
    const [nx, ny] = [-Math.sin(turned), Math.cos(turned)];
    // The base stays on the free side.
    const near = Math.max(0, NEAREST - (place[0] * nx + place[1] * ny));
    this.wall = [place[0] + near * nx, place[1] + near * ny, turned];
    this.solve();
  }

  /** The robot's pose in the frame of the wall. */
  private static pose([x, y, a]: [number, number, number]): Point {
    const [c, s] = [Math.cos(a), Math.sin(a)];
    return [-c * x - s * y, s * x - c * y];
  }

  /** A place of the wall's frame in that of the whisker. */
  private seen([u, v]: Point, turnOnly = false): Point {
    const [x, y, a] = this.wall;
    const [c, s] = [Math.cos(a), Math.sin(a)];
    return [c * u - s * v + (turnOnly ? 0 : x), s * u + c * v + (turnOnly ? 0 : y)];
  }

  /** Moves the wall on to where it is in small steps, as a robot would drive; from where it touches nothing at first. */
  private press(): void {
    const { simulator, wall } = this;
    if (!this.was) {
      simulator.readRobot();
      simulator.readMap("half.geojson", HALF);
      const far: [number, number, number] = [wall[0] - 0.1 * Math.sin(wall[2]), wall[1] + 0.1 * Math.cos(wall[2]), wall[2]];
      this.driven = simulator.startDrive(0, [...BendScene.pose(far), -far[2]], 0, false);
      this.was = far;
      this.event = "";
    }
    const was = this.was;
    const steps = Math.max(1, Math.ceil(Math.max(Math.hypot(wall[0] - was[0], wall[1] - was[1]) / STEP, Math.abs(wall[2] - was[2]) / TURN)));
    const t = this.driven!.rows[this.driven!.rows.length - this.driven!.width];
    const poses: number[] = [];
    for (let k = 1; k <= steps; k++) {
      const at = was.map((v, i) => v + (k / steps) * (wall[i] - v)) as [number, number, number];
      poses.push(t + k, ...BendScene.pose(at), -at[2], 0, 0, 0);
    }
    this.driven = simulator.drive(Float64Array.from(poses));
    this.was = [...wall];
    const told = this.driven.events.filter((event) => event.kind !== "single_contact").at(-1);
    if (told) this.event = told.detail.replace(/^w0 /, "The whisker ").replace(/ at \([^)]*\) m| \([^)]*\) m/g, "");
  }

  private movePost([x, y]: Point): void {
    const { left, right, bottom, top } = this.plot.box;
    const before = this.post;
    this.post = [Math.min(right - 4e-3, Math.max(left + 8e-3, x)), Math.min(top - 4e-3, Math.max(bottom + 4e-3, y))];
    if (!this.held) this.cross(before);
    this.solve();
  }

  /** A post that is beside the straight whisker pushes to where it goes. */
  private cross(before: Point): void {
    const within = (p: Point) => p[0] > 1e-3 && p[0] < LENGTH;
    if (within(this.post) && within(before) && before[1] * this.post[1] <= 0 && before[1] !== 0) this.side = before[1] > 0 ? -1 : 1;
  }

  private pull(place: Point): void {
    const held = this.held;
    if (!held) return;
    const norm = Math.hypot(...held.forceVector) || 1;
    const sign = Math.sign(this.force) || 1;
    const normal: Point = [(sign * held.forceVector[0]) / norm, (sign * held.forceVector[1]) / norm];
    const reach = (held.x - place[0]) * normal[0] + (held.y - place[1]) * normal[1];
    this.setForce(reach / ARROW);
  }

  private setForce(force: number): void {
    const bound = Math.min(MOST_FORCE, Math.max(-MOST_FORCE, force));
    this.force = Math.abs(bound) < 1e-3 ? 1e-3 * (Math.sign(bound) || 1) : bound;
    this.solve();
  }

  private slide([x, y]: Point): void {
    const shape = this.held?.shape ?? [];
    let best = 0;
    shape.forEach((p, i) => {
      if (Math.hypot(p[0] - x, p[1] - y) < Math.hypot(shape[best][0] - x, shape[best][1] - y)) best = i;
    });
    this.setArc((LENGTH * best) / Math.max(1, shape.length - 1));
  }

  private setArc(arc: number): void {
    this.arc = Math.min(LENGTH, Math.max(0.01, arc));
    this.solve();
  }

  private solve(): void {
    const before = this.held;
    if (this.mode === "wall") {
      this.held = undefined;
      this.others = [];
      this.ghost = [];
      this.press();
    } else if (this.mode === "force") {
      const all = this.stage.engine.bend("force", this.force, this.arc);
      this.held = all[0] ?? before;
      this.others = all.slice(1);
    } else {
      const free = this.post[0] <= 1e-3 || this.post[1] * this.side <= 0;
      const all = free ? [] : this.stage.engine.bend("point", ...this.post).filter((b) => b.force * this.side > 0);
      const near = (b: Bend) => (before ? Math.abs(b.moment - before.moment) : Math.abs(b.phi_a));
      all.sort((a, b) => near(a) - near(b));
      this.held = all[0];
      this.others = all.slice(1);
      if (before && !this.held) this.release(before);
    }
    if (this.held) cancelAnimationFrame(this.swing);
    this.draw();
    const [wx, wy, wa] = this.wall.map((v) => v.toFixed(5));
    this.stage.changed(this.mode === "wall" ? { mode: "wall", wx, wy, wa } : this.mode === "post"
      ? { mode: "post", x: this.post[0].toFixed(5), y: this.post[1].toFixed(5) }
      : { mode: "force", f: this.force.toFixed(5), s: this.arc.toFixed(5) });
    this.stage.announce(this.mode === "wall" ? `moment ${units.moment(this.pressed().moment)}` : this.held ? `moment ${units.moment(this.held.moment)}` : "the whisker is free");
  }

  /** The whisker springs back; a post that let it slip off now stands on its other side. */
  private release(before: Bend): void {
    const slipped = this.post[1] * this.side > 0;
    if (slipped) this.side = -this.side;
    if (still()) return;
    const began = performance.now();
    const frame = (now: number) => {
      const t = (now - began) / 1000;
      const size = Math.exp(-5 * t) * Math.cos(38 * t);
      this.ghost = before.shape.map(([x, y], i) => {
        const s = (LENGTH * i) / (before.shape.length - 1);
        return [s + (x - s) * size * size, y * size] as Point;
      });
      if (t > 0.9 || this.held) this.ghost = [];
      this.draw();
      if (this.ghost.length) this.swing = requestAnimationFrame(frame);
    };
    cancelAnimationFrame(this.swing);
    this.swing = requestAnimationFrame(frame);
  }

  private draw(): void {
    const { plot, held } = this;
    const straight: Point[] = [[0, 0], [LENGTH, 0]];
    ["rest", "wall", "others", "whisker", "marks"].forEach((layer) => plot.clear(layer));
    plot.scaleBar(0.02);
    plot.line("rest", straight, "rest");
    base(plot);
    for (const other of this.others) plot.line("others", other.shape, "other-branch");
    const pressed = this.mode === "wall" ? this.driven?.shapes[0]?.map((p) => this.seen(p)) : undefined;
    const shape = pressed ?? held?.shape ?? (this.ghost.length ? this.ghost : straight);
    plot.line("whisker", shape, "whisker");
    this.moment(this.mode === "wall" ? this.pressed().moment : held?.moment ?? 0);
    this.turn.show(this.mode === "wall");
    if (this.mode === "wall") this.drawWall();
    if (held) {
      const size = (Math.abs(held.force) * ARROW) / plot.pixel;
      const short = this.mode === "force" ? 0 : (20 * plot.pixel) / (Math.hypot(...held.forceVector) || 1);
      const end: Point = [held.x - short * held.forceVector[0], held.y - short * held.forceVector[1]];
      plot.arrow("marks", end, held.forceVector, this.mode === "force" ? size : 14 + Math.min(size, 90), "force");
      plot.dot("marks", [held.x, held.y], 4, "contact");
      this.slope(held);
    }
    this.along.show(this.mode === "force");
    if (this.mode === "wall") this.handle.moveTo([this.wall[0], this.wall[1]]);
    else if (this.mode === "post") this.handle.moveTo(this.post);
    else if (held) {
      const norm = Math.hypot(...held.forceVector) || 1;
      const back = (ARROW * Math.abs(this.force) + 13 * plot.pixel) / norm;
      this.handle.moveTo([held.x - held.forceVector[0] * back, held.y - held.forceVector[1] * back]);
      this.along.moveTo([held.x, held.y]);
    }
    this.tell();
  }

  /** What the simulated whisker feels, in its own frame. */
  private pressed(): { moment: number; touches: { at: Point; force: Point; size: number; side: boolean }[] } {
    const touches = (this.driven?.touches ?? []).map(({ at, force, side }) => ({
      at: this.seen(at), force: this.seen(force, true), size: Math.hypot(...force), side,
    }));
    return { moment: this.driven?.exact.at(-1)?.[0] ?? 0, touches };
  }

  private drawWall(): void {
    const { plot } = this;
    const corners: Point[] = [[-0.3, 0], [0.3, 0], [0.3, 0.3], [-0.3, 0.3]];
    plot.line("wall", corners.map((p) => this.seen(p)), "half", true);
    plot.line("wall", [this.seen([-0.3, 0]), this.seen([0.3, 0])], "wall");
    for (const touch of this.pressed().touches) {
      plot.arrow("marks", touch.at, touch.force, 14 + Math.min(90, (touch.size * ARROW) / plot.pixel), "force");
      plot.dot("marks", touch.at, 4, "contact");
    }
    this.turn.moveTo(this.seen([ARM, 0]));
  }

  /** The equilibrium that the simulated whisker is in, where the wall touches it at one place. */
  private shapeAtWall(): Bend | undefined {
    const { moment, touches } = this.pressed();
    if (touches.length !== 1) return undefined;
    const [{ at, force, size, side }] = touches;
    const { engine } = this.stage;
    const all = side ? engine.bend("point", ...at) : engine.bend("force", size, LENGTH, Math.atan2(force[1], force[0]));
    const off = (bend: Bend) => Math.abs(bend.moment - moment);
    return all.reduce<Bend | undefined>((best, bend) => (best && off(best) <= off(bend) ? best : bend), undefined);
  }

  private tellWall(): void {
    const { readout } = this;
    const { moment, touches } = this.pressed();
    const [touch] = touches;
    readout.set("Moment at the base", units.moment(moment), "main");
    readout.set("Force", touch ? units.force(touches.reduce((sum, one) => sum + one.size, 0)) : "–");
    const shape = this.shapeAtWall();
    const of = (value: (b: Bend) => string) => (shape ? value(shape) : touch ? "two contacts" : "–");
    readout.set("Slope at the contact", of((b) => units.angle(b.phi_a)));
    readout.set("Arc length to it", shape && touch.side ? units.length(shape.s_a) : touches.length > 1 ? "two contacts" : touch ? (touch.side ? "on its side" : "at the tip") : "–");
    readout.set("Contact point", touch ? `${units.quantity(1e3 * touch.at[0], 1, "")}, ${units.length(touch.at[1])}` : "–");
    readout.set("Largest strain", of((b) => units.quantity(100 * b.strain, 2, "%")), shape && shape.strain > STRAIN_LIMIT ? "bad" : "");
    readout.set("Elastic energy", of((b) => units.quantity(1e6 * b.energy, 0, "µJ")));
    this.note.textContent = this.event ? `${this.event}.` : "Drag the wall against the whisker, and turn it by the small handle.";
  }

  /** The moment as an arc about the base: its length is its size. */
  private moment(moment: number): void {
    const { plot } = this;
    const [x, y] = plot.at([0, 0]);
    const turn = Math.max(-2.6, Math.min(2.6, moment / 6e-3));
    if (Math.abs(turn) < 0.02) return;
    const r = 26;
    const end = (a: number): Point => [x + r * Math.cos(a), y - r * Math.sin(a)];
    const [from, to] = [end(0), end(turn)];
    const large = Math.abs(turn) > Math.PI ? 1 : 0;
    const sweep = turn > 0 ? 0 : 1;
    plot.layer("marks").append(make("path", {
      d: `M${from.join(" ")}A${r} ${r} 0 ${large} ${sweep} ${to.join(" ")}`, class: "moment-arc",
    }));
    plot.layer("marks").append(make("circle", { cx: to[0], cy: to[1], r: 3.5, class: "moment-end" }));
    const words = make("text", { x: x + 8, y: y + (turn > 0 ? 44 : -34), class: "label moment-words", "text-anchor": "middle" });
    words.textContent = units.moment(moment);
    plot.layer("marks").append(words);
  }

  private slope(held: Bend): void {
    const reach = 0.012;
    const [c, s] = [Math.cos(held.phi_a), Math.sin(held.phi_a)];
    this.plot.line("marks", [[held.x - reach * c, held.y - reach * s], [held.x + reach * c, held.y + reach * s]], "tangent");
  }

  private tell(): void {
    if (this.mode === "wall") {
      this.tellWall();
      return;
    }
    const { held, readout } = this;
    const of = (value: (b: Bend) => string) => (held ? value(held) : "–");
    readout.set("Moment at the base", units.moment(held?.moment ?? 0), "main");
    readout.set("Force", of((b) => units.force(b.force)));
    readout.set("Slope at the contact", of((b) => units.angle(b.phi_a)));
    readout.set("Arc length to it", of((b) => units.length(b.s_a)));
    readout.set("Contact point", of((b) => `${units.quantity(1e3 * b.x, 1, "")}, ${units.length(b.y)}`));
    readout.set("Largest strain", of((b) => units.quantity(100 * b.strain, 2, "%")), held && held.strain > STRAIN_LIMIT ? "bad" : "");
    readout.set("Elastic energy", of((b) => units.quantity(1e6 * b.energy, 0, "µJ")));
    const others = this.others.length;
    this.note.textContent = !held
      ? "The whisker is free. Push the post through it from one side."
      : held.strain > STRAIN_LIMIT
        ? "Beyond the limit of Nitinol: this whisker would stay bent."
        : others > 0
          ? `The dashed line is ${others === 1 ? "another shape" : `${others} other shapes`} in equilibrium with the same ${this.mode === "post" ? "contact point" : "force"}.`
          : this.mode === "post"
            ? "Push further: the whisker slides over the post, and snaps free at its tip."
            : "Drag the arrow to push harder, and the small handle along the whisker.";
  }

  answers(): unknown {
    if (this.mode === "wall") return { mode: "wall", ...this.pressed(), shape: this.shapeAtWall() };
    const given = this.mode === "post" ? { x: this.post[0], y: this.post[1] } : { force: this.force, s_a: this.arc };
    const all = this.mode === "post"
      ? this.stage.engine.bend("point", ...this.post)
      : this.stage.engine.bend("force", this.force, this.arc);
    return { mode: this.mode, given, solutions: all };
  }
}

/** The clamp that holds the whisker. */
export function base(plot: Plot): void {
  const [x, y] = plot.at([0, 0]);
  const group = make("g", { class: "clamp" });
  group.append(make("rect", { x: x - 26, y: y - 13, width: 26, height: 26, rx: 5 }), make("circle", { cx: x - 13, cy: y, r: 4 }));
  plot.layer("rest").append(group);
}
