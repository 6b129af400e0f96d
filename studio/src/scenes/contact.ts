// One reading, many contacts: where can what the whisker touches be?

import type { Bend, Contact, ContactSet, Point, Sensor } from "../engine";
import { choice, Readout, saving, slider } from "../controls";
import { Handle, Plot, make } from "../plot";
import type { Remote } from "../remote";
import { number, type Running, type Scene, type Stage } from "../scene";
import * as units from "../units";
import { base } from "./bend";

const SHAPES = 14;
const SENSORS: { value: Sensor; words: string; name: string }[] = [
  { value: "moment", words: "moment", name: "the moment at the base" },
  { value: "load", words: "force", name: "the contact force" },
  { value: "slope", words: "slope", name: "the slope at the contact" },
  { value: "strip", words: "strip", name: "where along the whisker it is touched" },
];
const MOVE = "M-4 0H4M0 -4V4";

export const contact: Scene = {
  id: "contact",
  tab: "Contact set",
  title: "One reading, many contacts",
  lead: "The base reads one number and does not know where the whisker is touched. Every contact on the blue curve gives the same reading. Drag the contact.",
  start: (stage) => new ContactScene(stage),
};

/** What a sensor reads of a contact. */
export function read(sensor: Sensor, c: Contact | Bend): number {
  return { load: c.force, strip: c.s_a, slope: c.phi_a, moment: c.moment }[sensor];
}

export function readingWords(sensor: Sensor, value: number): string {
  return { load: units.force, strip: units.length, slope: units.angle, moment: units.moment }[sensor](value);
}

class ContactScene implements Running {
  private place: Point;
  private sensor: Sensor;
  private error: number;
  private truth: Bend | undefined;
  private set: ContactSet | undefined;
  /** The contacts within the error, and the bounds that they belong to: they take longer and come from a worker. */
  private region: ContactSet | undefined;
  private asked: Point = [NaN, NaN];
  private busy = false;
  private readonly worker: Remote;
  private value = 0;
  private readonly plot: Plot;
  private readonly handle: Handle;
  private readonly readout: Readout;

  constructor(private readonly stage: Stage) {
    const { state } = stage;
    this.place = [number(state, "x", 0.055), number(state, "y", 0.021)];
    this.sensor = SENSORS.find((s) => s.value === state.sensor)?.value ?? "moment";
    this.error = number(state, "error", 5);
    stage.engine.readRobot();
    this.worker = stage.worker();
    this.plot = new Plot(stage.figure, { left: -0.03, right: 0.09, bottom: -0.016, top: 0.064 }, "Contacts that explain a reading", () => this.draw());
    for (const layer of ["rest", "region", "shapes", "curve", "whisker", "marks", "handles"]) this.plot.layer(layer);
    choice(stage.panel, "The sensor reads", SENSORS, this.sensor, (sensor) => {
      this.sensor = sensor;
      this.region = undefined;
      this.asked = [NaN, NaN];
      this.solve();
    });
    slider(stage.panel, "Error of the reading", { min: 0, max: 20, step: 1 }, this.error, (v) => `± ${v}\u202f%`, (v) => {
      this.error = v;
      this.solve();
    });
    this.readout = new Readout(stage.panel);
    saving(stage.panel, "contact-set.svg", () => this.picture());
    this.handle = new Handle(this.plot, {
      name: "The true contact", icon: MOVE, kind: "push",
      value: () => `${units.length(this.place[0])} along, ${units.length(this.place[1])} across`,
      drag: (place) => this.move(place),
      nudge: (right, up) => this.move([this.place[0] + 1e-3 * right, this.place[1] + 1e-3 * up]),
    });
    this.solve();
  }

  picture(): string {
    return this.plot.picture(`Contacts that explain a ${this.sensor} of ${readingWords(this.sensor, this.value)}`);
  }

  redraw(): void {
    this.draw();
  }

  end(): void {
    this.plot.end();
  }

  private move(place: Point): void {
    const [found] = this.stage.engine.bend("point", ...place);
    if (place[0] < 5e-3 || Math.abs(place[1]) < 5e-4 || !found) return;
    const { bottom, top } = this.plot.box;
    if (place[1] < bottom + 3e-3 || place[1] > top - 3e-3) return;
    this.place = place;
    this.solve();
  }

  private bounds(): Point {
    const half = (Math.abs(this.value) * this.error) / 100;
    return [this.value - half, this.value + half];
  }

  private solve(): void {
    [this.truth] = this.stage.engine.bend("point", ...this.place);
    if (!this.truth) return;
    this.value = read(this.sensor, this.truth);
    this.set = this.stage.engine.contactSet(this.sensor, this.value, this.value, SHAPES);
    if (this.error === 0) this.region = undefined;
    else void this.widen();
    this.draw();
    this.stage.changed({ x: this.place[0].toFixed(5), y: this.place[1].toFixed(5), sensor: this.sensor, error: `${this.error}` });
    this.stage.announce(`${this.words()}: ${this.set.curves.length} curves of contacts`);
  }

  /** Asks for the region of the newest reading, one at a time. */
  private async widen(): Promise<void> {
    if (this.busy) return;
    this.busy = true;
    while (this.asked.some((v, i) => v !== this.bounds()[i])) {
      const [sensor, bounds] = [this.sensor, this.bounds()];
      this.asked = bounds;
      const region = await this.worker.call("contactSet", sensor, ...bounds, 0);
      if (sensor === this.sensor && this.error > 0) this.region = region;
      this.draw();
    }
    this.busy = false;
  }

  private words(): string {
    return `${this.sensor === "load" ? "force" : this.sensor} ${readingWords(this.sensor, this.value)}`;
  }

  private draw(): void {
    const { plot, set, truth } = this;
    if (!set || !truth) return;
    ["rest", "region", "shapes", "curve", "whisker", "marks"].forEach((layer) => plot.clear(layer));
    plot.scaleBar(0.02);
    plot.line("rest", [[0, 0], [0.075, 0]], "rest");
    base(plot);
    const region = this.region;
    if (region) {
      const d = region.cells.map((cell) => plot.path(cell, true)).join("");
      plot.layer("region").append(make("path", { d, class: "region" }));
    }
    set.shapes.forEach((shape) => plot.line("shapes", shape, "possible"));
    set.curves.forEach((curve) => plot.line("curve", curve.map((c) => [c.x, c.y] as Point), "set-curve"));
    plot.line("whisker", truth.shape, "whisker");
    this.handle.moveTo(this.place);
    const { readout } = this;
    const length = set.curves.reduce((sum, curve) => sum + lengthOf(curve), 0);
    readout.set("Reading", readingWords(this.sensor, this.value), "main");
    readout.set("Within", this.bounds().map((v) => readingWords(this.sensor, v)).join(" to "));
    readout.set("Curves of contacts", `${set.curves.length}, ${units.length(length)} long`);
    readout.set("Region within the error", region ? units.area(region.area) : this.error === 0 ? "only the curve" : "…");
    readout.set("Curve is exact to", units.quantity(1e6 * set.tolerance, 1, "µm"));
  }

  answers(): unknown {
    const { sensor, value, error, set, region } = this;
    return { ready: error === 0 || (!this.busy && region), sensor, value, error, set, region };
  }
}

function lengthOf(curve: Contact[]): number {
  return curve.slice(1).reduce((sum, c, i) => sum + Math.hypot(c.x - curve[i].x, c.y - curve[i].y), 0);
}
