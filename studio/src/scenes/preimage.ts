// One reading on a map: where can the robot be?

import type { Point, Preimage, RoomMap } from "../engine";
import { choice, Readout, slider } from "../controls";
import { Handle, Plot, colour, make } from "../plot";
import { number, type Running, type Scene, type Stage } from "../scene";
import type { Remote } from "../remote";
import { MOUNT, ROOMS, robotFile, roomBox, roomOf, type Room } from "../rooms";
import { drawRobot } from "../robot";
import * as units from "../units";

/** Cells (m) and headings while one drags, and when one looks. */
const COARSE: Point = [6e-3, 60];
const FINE: Point = [2.5e-3, 120];
/** How long the hand must rest before the fine set is computed (ms). */
const REST = 220;
const MOVE = "M-4 0H4M0 -4V4";

export const preimage: Scene = {
  id: "preimage",
  tab: "Preimage",
  title: "One reading, many places",
  lead: "A single reading on a known map: the robot can be anywhere in the blue, which is stronger where more headings are possible. Drag the probe to see which.",
  start: async (stage) => {
    const scene = new PreimageScene(stage);
    await scene.open();
    return scene;
  },
};

class PreimageScene implements Running {
  private room: Room;
  private moment: number;
  private error: number;
  private probe: Point;
  private map: RoomMap = { outlines: [], warnings: [] };
  private found: Preimage | undefined;
  private asked = 0;
  private timer = 0;
  private busy = false;
  private again = false;
  private fine = false;
  private runs: Point[] = [];
  private readonly worker: Remote;
  private readonly plot: Plot;
  private readonly handle: Handle;
  private readonly readout: Readout;
  private raster: HTMLCanvasElement | undefined;

  constructor(private readonly stage: Stage) {
    const { state } = stage;
    this.room = roomOf(state.room);
    this.moment = number(state, "m", 4);
    this.error = number(state, "error", 5);
    this.probe = [number(state, "x", NaN), number(state, "y", NaN)];
    this.worker = stage.worker();
    this.plot = new Plot(stage.figure, { left: 0, right: 0.5, bottom: 0, top: 0.35 }, "A map and the places that explain a reading", () => this.fit());
    for (const layer of ["map", "probe", "handles"]) this.plot.layer(layer);
    choice(stage.panel, "Room", ROOMS.map((r) => ({ value: r.id, words: r.words })), this.room.id, (id) => {
      this.room = roomOf(id);
      this.probe = [NaN, NaN];
      void this.open();
    });
    slider(stage.panel, "The whisker reads", { min: -12, max: 12, step: 0.1 }, this.moment, (v) => units.quantity(v, 1, "mN m"), (v) => {
      this.moment = v;
      this.change();
    });
    slider(stage.panel, "Error of the reading", { min: 0, max: 20, step: 1 }, this.error, (v) => `± ${v}\u202f%`, (v) => {
      this.error = v;
      this.change();
    });
    this.readout = new Readout(stage.panel);
    this.handle = new Handle(this.plot, {
      name: "The probe: a place whose headings are shown", icon: MOVE, kind: "push place",
      value: () => `at ${units.length(this.probe[0], 0)}, ${units.length(this.probe[1], 0)}: ${this.share()} of all headings`,
      drag: (place) => this.look(place),
      nudge: (right, up) => this.look([this.probe[0] + 2e-3 * right, this.probe[1] + 2e-3 * up]),
    });
  }

  async open(): Promise<void> {
    await this.worker.call("readRobot", "robot.toml", robotFile(false));
    this.fine = false;
    this.map = await this.worker.call("readMap", this.room.file, this.room.map);
    this.plot.show(roomBox(this.map));
    if (!Number.isFinite(this.probe[0])) this.probe = [this.room.start[0], this.room.start[1]];
    this.found = undefined;
    this.fit();
    this.change();
  }

  redraw(): void {
    this.fit();
  }

  end(): void {
    clearTimeout(this.timer);
    this.asked += 1;
    this.plot.end();
  }

  private change(): void {
    clearTimeout(this.timer);
    void this.solve(COARSE);
    this.timer = window.setTimeout(() => void this.solve(FINE), REST);
  }

  private bounds(): Point {
    const value = 1e-3 * this.moment;
    const half = (Math.abs(value) * this.error) / 100;
    return [value - half, value + half];
  }

  private async solve([cell, headings]: Point): Promise<void> {
    if (this.busy) {
      this.again = true;
      return;
    }
    this.busy = true;
    const asked = ++this.asked;
    const [lo, hi] = this.bounds();
    const found = await this.worker.call("preimage", "moment", lo, hi, cell, headings);
    this.busy = false;
    if (asked !== this.asked) return;
    this.found = found;
    this.fine = cell === FINE[0];
    this.paint();
    await this.ask();
    this.draw();
    this.stage.changed({
      room: this.room.id, m: this.moment.toFixed(1), error: `${this.error}`, x: this.probe[0].toFixed(4), y: this.probe[1].toFixed(4),
    });
    if (this.again) {
      this.again = false;
      this.change();
    }
  }

  private look([x, y]: Point): void {
    const { left, right, bottom, top } = this.plot.box;
    this.probe = [Math.min(right, Math.max(left, x)), Math.min(top, Math.max(bottom, y))];
    this.draw();
    void this.ask().then(() => this.draw());
  }

  private async ask(): Promise<void> {
    if (!Number.isFinite(this.probe[0])) return;
    this.runs = await this.worker.call("headings", ...this.probe);
  }

  private share(): string {
    const sum = this.runs.reduce((all, [from, to]) => all + to - from, 0);
    return units.quantity((100 * sum) / (2 * Math.PI), 0, "%");
  }

  /** The set as a picture with one pixel for each cell. */
  private paint(): void {
    const { found } = this;
    if (!found) return;
    const raster = document.createElement("canvas");
    [raster.width, raster.height] = [found.columns, found.rows];
    const pen = raster.getContext("2d")!;
    const image = pen.createImageData(found.columns, found.rows);
    const probe = document.createElement("canvas").getContext("2d")!;
    probe.fillStyle = colour("set");
    const hex = probe.fillStyle;
    const rgb = [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16));
    const most = found.share.reduce((a, b) => Math.max(a, b), 1e-9);
    for (let row = 0; row < found.rows; row++) {
      for (let column = 0; column < found.columns; column++) {
        const share = found.share[row * found.columns + column];
        const at = 4 * ((found.rows - 1 - row) * found.columns + column);
        image.data.set(rgb, at);
        image.data[at + 3] = share > 0 ? 45 + 190 * Math.sqrt(share / most) : 0;
      }
    }
    pen.putImageData(image, 0, 0);
    this.raster = raster;
  }

  private fit(): void {
    this.plot.map(this.map.outlines);
    this.plot.scaleBar(0.05);
    this.paint();
    this.draw();
  }

  private draw(): void {
    const { plot, found, probe } = this;
    const pen = plot.pen();
    if (found && this.raster) {
      const [x, y] = plot.at([found.origin[0], found.origin[1] + found.rows * found.cell]);
      const scale = found.cell / plot.pixel;
      pen.save();
      pen.clip(new Path2D(this.map.outlines.filter((o) => o.role === "arena").map((o) => plot.path(o.points, true)).join("")));
      pen.drawImage(this.raster, x, y, found.columns * scale, found.rows * scale);
      pen.restore();
    }
    plot.clear("probe");
    if (Number.isFinite(probe[0])) {
      const [x, y] = plot.at(probe);
      const r = 46;
      for (const [from, to] of this.runs) {
        const at = (a: number) => `${(x + r * Math.cos(a)).toFixed(1)} ${(y - r * Math.sin(a)).toFixed(1)}`;
        const whole = to - from > 2 * Math.PI - 1e-6;
        const d = whole
          ? `M${x - r} ${y}a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0Z`
          : `M${x} ${y}L${at(from)}A${r} ${r} 0 ${to - from > Math.PI ? 1 : 0} 0 ${at(to)}Z`;
        plot.layer("probe").append(make("path", { d, class: "headings" }));
      }
      const run = [...this.runs].sort((a, b) => b[1] - b[0] - (a[1] - a[0]))[0];
      if (run) {
        const theta = 0.5 * (run[0] + run[1]);
        drawRobot(plot, "probe", [...probe, theta], "robot");
        const far: Point = [probe[0] + 0.03 * Math.cos(theta + MOUNT), probe[1] + 0.03 * Math.sin(theta + MOUNT)];
        plot.line("probe", [probe, far], "mount");
      }
      this.handle.moveTo(probe);
    }
    const { readout } = this;
    readout.set("Places", found ? (found.empty ? "none" : units.area(found.area)) : "–", "main");
    readout.set("Volume of states", found ? units.quantity(1e4 * found.volume, 1, "cm² rad") : "–");
    readout.set("Headings at the probe", this.share());
    readout.set("Cells", found ? `${units.length(found.cell)}${this.fine ? "" : ", refining"}` : "–");
    readout.set("Sampled within", found ? units.length(found.deviation, 2) : "–");
  }

  async answers(): Promise<unknown> {
    const [lo, hi] = this.bounds();
    const [cell, headings] = FINE;
    const { share, ...found } = await this.worker.call("preimage", "moment", lo, hi, cell, headings);
    return { map: this.room.map, file: this.room.file, robot: robotFile(false), lo, hi, cell, headings, found, cells: share.filter((s) => s > 0).length };
  }
}
