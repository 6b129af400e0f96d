// The library as WebAssembly: bytes in, numbers out. The layouts are those of crates/vibrissa-wasm/src/abi.rs. All SI.

export type Point = [number, number];

interface Exports {
  memory: WebAssembly.Memory;
  input(len: number): number;
  numbers(): number;
  numbers_len(): number;
  text(): number;
  text_len(): number;
  read(kind: number): number;
  bend(given: number, a: number, b: number, load: number, angle: number): number;
  contact_set(sensor: number, lo: number, hi: number, shapes: number): number;
  preimage(sensor: number, lo: number, hi: number, cell: number, headings: number): number;
  headings(x: number, y: number): number;
  drive(op: number): number;
  localize(op: number, n: number): number;
  estimate(most: number): number;
  whiskers(row: number, x: number, y: number, theta: number): number;
  write(kind: number): number;
}

/** What the library has to say against an input, in the words of the command. */
export class Refused extends Error {}

export interface Outline {
  role: "arena" | "obstacle" | "wall";
  closed: boolean;
  points: Point[];
}

export interface RoomMap {
  outlines: Outline[];
  warnings: string[];
}

export interface Whisker {
  length: number;
  mount: [number, number, number];
}

export interface Bend {
  force: number;
  s_a: number;
  phi_a: number;
  beta: number;
  x: number;
  y: number;
  moment: number;
  forceVector: Point;
  energy: number;
  tip: Point;
  strain: number;
  strainAt: number;
  shape: Point[];
}

export interface Contact {
  x: number;
  y: number;
  s_a: number;
  phi_a: number;
  force: number;
  moment: number;
}

export interface ContactSet {
  tolerance: number;
  curves: Contact[][];
  area: number;
  components: number;
  cells: Point[][];
  shapes: Point[][];
}

export interface Preimage {
  empty: boolean;
  area: number;
  sampledArea: number;
  volume: number;
  deviation: number;
  origin: Point;
  cell: number;
  columns: number;
  rows: number;
  share: Float64Array;
}

/** A whisker on the map: as the map bends it, as its reading alone does, or at rest. */
export interface BentWhisker {
  from: "rest" | "reading" | "map";
  contact: Point;
  moment: number;
  shape: Point[];
}

export interface Touch {
  whisker: number;
  at: Point;
  force: Point;
  side: boolean;
}

export interface Driven {
  width: number;
  /** Rows of t, x, y, theta and readings. */
  rows: Float64Array;
  exact: number[][];
  touches: Touch[];
  shapes: Point[][];
  events: { t: number; kind: string; detail: string }[];
}

export const VERDICTS = ["localized", "ambiguous", "inconsistent", "no_contact"] as const;
export type Verdict = (typeof VERDICTS)[number];

export interface Place {
  x: number;
  y: number;
  theta: number;
  weight: number;
  extent: [number, number, number, number, number, number];
  position: number;
  heading: number;
}

export interface Estimate {
  verdict: Verdict;
  rows: number;
  places: Place[];
  /** States as x, y, theta. */
  states: Float64Array;
}

export interface Answer extends Estimate {
  /** Poses as t, x, y, theta. */
  trajectory: Float64Array;
  words: {
    events: { t: number; kind: string; detail: string }[];
    nuisances: { quantity: string; whisker: string | null; unit: string; estimate: number; std: number; significant: boolean; words: string }[];
    consistency: { statistic: number; most: number } | null;
  };
}

export type Sensor = "load" | "strip" | "slope" | "moment";
const SENSORS: Sensor[] = ["load", "strip", "slope", "moment"];
const FILES = ["map", "robot", "log", "truth"] as const;
export type FileKind = (typeof FILES)[number];
const WRITTEN = ["log", "robot", "figure", "trajectory", "map"] as const;

/** Reads numbers one after another. */
class Cursor {
  private at = 0;
  constructor(private readonly values: Float64Array) {}
  next(): number {
    return this.values[this.at++];
  }
  take(count: number): Float64Array {
    this.at += count;
    return this.values.slice(this.at - count, this.at);
  }
  points(count: number): Point[] {
    return Array.from({ length: count }, () => [this.next(), this.next()] as Point);
  }
}

export class Engine {
  private constructor(private readonly wasm: Exports) {}

  static async of(module: WebAssembly.Module): Promise<Engine> {
    const instance = await WebAssembly.instantiate(module, {});
    return new Engine(instance.exports as unknown as Exports);
  }

  private give(bytes: Uint8Array): void {
    const at = this.wasm.input(bytes.length);
    new Uint8Array(this.wasm.memory.buffer, at, bytes.length).set(bytes);
  }

  private text(): string {
    return new TextDecoder().decode(new Uint8Array(this.wasm.memory.buffer, this.wasm.text(), this.wasm.text_len()));
  }

  private numbers(status: number): Cursor {
    if (status !== 0) throw new Refused(this.text());
    return new Cursor(new Float64Array(this.wasm.memory.buffer, this.wasm.numbers(), this.wasm.numbers_len()).slice());
  }

  private file(kind: FileKind, name: string, content: string | Uint8Array): Cursor {
    const encode = (text: string) => new TextEncoder().encode(text);
    const [head, body] = [encode(`${name}\0`), typeof content === "string" ? encode(content) : content];
    const bytes = new Uint8Array(head.length + body.length);
    bytes.set(head);
    bytes.set(body, head.length);
    this.give(bytes);
    return this.numbers(this.wasm.read(FILES.indexOf(kind)));
  }

  readMap(name: string, content: string | Uint8Array): RoomMap {
    const cursor = this.file("map", name, content);
    const outlines = Array.from({ length: cursor.next() }, (): Outline => {
      const role = (["arena", "obstacle", "wall"] as const)[cursor.next()];
      const closed = cursor.next() === 1;
      return { role, closed, points: cursor.points(cursor.next()) };
    });
    return { outlines, warnings: this.text().split("\n").filter(Boolean) };
  }

  /** Without a name the paper's whisker. */
  readRobot(name = "", content: string | Uint8Array = ""): Whisker[] {
    const cursor = this.file("robot", name, content);
    return Array.from({ length: cursor.next() }, () => ({
      length: cursor.next(),
      mount: [cursor.next(), cursor.next(), cursor.next()] as [number, number, number],
    }));
  }

  readLog(name: string, content: string | Uint8Array): { columns: string[]; rows: Float64Array; width: number; warnings: string[] } {
    const cursor = this.file("log", name, content);
    const [count, columns] = [cursor.next(), cursor.next()];
    const [head, ...warnings] = this.text().split("\n");
    const width = 4 + columns;
    return { columns: head.split(" "), rows: cursor.take(count * width), width, warnings };
  }

  readTruth(name: string, content: string | Uint8Array): Float64Array {
    const cursor = this.file("truth", name, content);
    return cursor.take(4 * cursor.next());
  }

  /** Equilibria; the force is normal to the whisker, or has the direction `angle` (rad). */
  bend(given: "force" | "point" | "moment" | "tip", a: number, b: number, angle?: number): Bend[] {
    const which = ["force", "point", "moment", "tip"].indexOf(given);
    const cursor = this.numbers(this.wasm.bend(which, a, b, angle === undefined ? 0 : 3, angle ?? 0));
    const [count, points] = [cursor.next(), cursor.next()];
    return Array.from({ length: count }, (): Bend => {
      const [force, s_a, phi_a, beta, x, y, moment, fx, fy, energy, tx, ty, strain, strainAt] = cursor.take(14);
      return {
        force, s_a, phi_a, beta, x, y, moment, energy, strain, strainAt,
        forceVector: [fx, fy], tip: [tx, ty], shape: cursor.points(points),
      };
    });
  }

  contactSet(sensor: Sensor, lo: number, hi: number, shapes: number): ContactSet {
    const cursor = this.numbers(this.wasm.contact_set(SENSORS.indexOf(sensor), lo, hi, shapes));
    const [count, tolerance] = [cursor.next(), cursor.next()];
    const curves = Array.from({ length: count }, () =>
      Array.from({ length: cursor.next() }, (): Contact => {
        const [x, y, s_a, phi_a, force, moment] = cursor.take(6);
        return { x, y, s_a, phi_a, force, moment };
      }),
    );
    const [area, components, cells] = [cursor.next(), cursor.next(), cursor.next()];
    const polygons = (n: number) => Array.from({ length: n }, () => cursor.points(cursor.next()));
    return { tolerance, curves, area, components, cells: polygons(cells), shapes: polygons(cursor.next()) };
  }

  preimage(sensor: Sensor, lo: number, hi: number, cell: number, headings: number): Preimage {
    const cursor = this.numbers(this.wasm.preimage(SENSORS.indexOf(sensor), lo, hi, cell, headings));
    const [empty, area, sampledArea, volume, deviation, x, y, side, columns, rows] = cursor.take(10);
    return {
      empty: empty === 1, area, sampledArea, volume, deviation, origin: [x, y], cell: side, columns, rows,
      share: cursor.take(columns * rows),
    };
  }

  headings(x: number, y: number): Point[] {
    const status = this.wasm.headings(x, y);
    const cursor = this.numbers(status);
    return cursor.points(this.wasm.numbers_len() / 2);
  }

  startDrive(t: number, pose: [number, number, number], seed: number, noise: boolean): Driven {
    this.give(new Uint8Array(new Float64Array([t, ...pose, seed, noise ? 1 : 0]).buffer));
    return this.driven(0);
  }

  /** Poses of t, x, y, theta, zero, gain, slip. */
  drive(poses: Float64Array): Driven {
    this.give(new Uint8Array(poses.slice().buffer));
    return this.driven(1);
  }

  private driven(op: number): Driven {
    const cursor = this.numbers(this.wasm.drive(op));
    const [count, whiskers] = [cursor.next(), cursor.next()];
    const width = 4 + whiskers;
    const rows = new Float64Array(count * width);
    const exact: number[][] = [];
    for (let row = 0; row < count; row++) {
      rows.set(cursor.take(width), row * width);
      exact.push([...cursor.take(whiskers)]);
    }
    const touches = Array.from({ length: cursor.next() }, (): Touch => {
      const [whisker, x, y, fx, fy, side] = cursor.take(6);
      return { whisker, at: [x, y], force: [fx, fy], side: side === 1 };
    });
    const shapes = Array.from({ length: whiskers }, () => cursor.points(cursor.next()));
    const events = this.text().split("\n").filter(Boolean).map((line) => {
      const [t, kind, detail] = line.split("\t");
      return { t: Number(t), kind, detail };
    });
    return { width, rows, exact, touches, shapes, events };
  }

  /** Begins with a method and its options that are words: "probabilistic undeclared=none". */
  beginLocalize(method: string): void {
    this.give(new TextEncoder().encode(method));
    this.numbers(this.wasm.localize(0, 0));
  }

  addRows(rows: Float64Array): void {
    this.give(new Uint8Array(rows.slice().buffer));
    this.numbers(this.wasm.localize(1, 0));
  }

  /** Takes up to n rows; how many are taken and how many there are. */
  step(n: number): [number, number, boolean] {
    return this.progress(2, n);
  }

  /** Works so many units, at most to the end of a row; also whether no work is left on the rows that were taken. */
  advance(units: number): [number, number, boolean] {
    return this.progress(4, units);
  }

  /** Ends the rows: the work of the end is left to `advance`. */
  endRows(): void {
    this.progress(5, 0);
  }

  private progress(op: number, n: number): [number, number, boolean] {
    const cursor = this.numbers(this.wasm.localize(op, n));
    return [cursor.next(), cursor.next(), cursor.next() === 1];
  }

  estimate(most: number): Estimate {
    return this.told(this.numbers(this.wasm.estimate(most)));
  }

  finish(): Answer {
    const cursor = this.numbers(this.wasm.localize(3, 0));
    const words = JSON.parse(this.text()) as Answer["words"];
    const estimate = this.told(cursor);
    return { ...estimate, trajectory: cursor.take(4 * cursor.next()), words };
  }

  /** The whiskers at a row of the log, with the robot at this pose. */
  whiskers(row: number, x: number, y: number, theta: number): BentWhisker[] {
    const cursor = this.numbers(this.wasm.whiskers(row, x, y, theta));
    return Array.from({ length: cursor.next() }, (): BentWhisker => {
      const [from, cx, cy, moment, points] = cursor.take(5);
      return { from: (["rest", "reading", "map"] as const)[from], contact: [cx, cy], moment, shape: cursor.points(points) };
    });
  }

  private told(cursor: Cursor): Estimate {
    const [verdict, rows, places, states] = cursor.take(4);
    return {
      verdict: VERDICTS[verdict],
      rows,
      places: Array.from({ length: places }, (): Place => {
        const [x, y, theta, weight, ...rest] = cursor.take(12);
        const extent = rest.slice(0, 6) as Place["extent"];
        return { x, y, theta, weight, extent, position: rest[6], heading: rest[7] };
      }),
      states: cursor.take(3 * states),
    };
  }

  write(what: (typeof WRITTEN)[number], title = ""): string {
    this.give(new TextEncoder().encode(title));
    this.numbers(this.wasm.write(WRITTEN.indexOf(what)));
    return this.text();
  }
}
