// A worker with a library of its own: it answers calls, and localizes in slices so that it can always be told something new.

import { Engine, Refused, type Estimate } from "./engine";

/** How long a slice may take (ms), and how much work is done between two looks at the clock: some tenths of a millisecond. */
const SLICE = 2.5;
const UNITS = 100;
/** How often an estimate is told (ms), how many states are told. */
const TOLD = 40;
const MOST_STATES = 4000;
const SNAPSHOT_STATES = 1500;

export type Request =
  | { op: "module"; module: WebAssembly.Module }
  | { op: "call"; id: number; name: string; args: unknown[] }
  /** Tells an estimate every so many rows, or with 0 now and then. */
  | { op: "follow"; run: number; every: number };

export type Reply =
  | { op: "answer"; id: number; result: unknown }
  | { op: "refused"; id: number; words: string; plain: boolean }
  | { op: "progress"; run: number; taken: number; all: number; estimate?: Estimate; slice: number; telling: number; failed?: string };

const scope = self as unknown as { postMessage(message: Reply, transfer?: Transferable[]): void; onmessage: unknown };
let engine: Promise<Engine>;
let run = -1;
let scheduled = false;
let told = 0;
let every = 0;
/** Rows that were taken when an estimate was told last. */
let toldAt = -1;
/** The call that waits for the answer at the end. */
let finishing: number | undefined;

/** What of an answer is handed over rather than copied. */
function arrays(result: unknown): Transferable[] {
  const parts = result && typeof result === "object" ? [result, ...Object.values(result)] : [];
  return parts.filter((part) => part instanceof Float64Array).map((part) => part.buffer as ArrayBuffer);
}

const channel = new MessageChannel();
channel.port1.onmessage = () => {
  scheduled = false;
  void engine.then(slice);
};

function schedule(): void {
  if (scheduled || run < 0) return;
  scheduled = true;
  channel.port2.postMessage(0);
}

function tell(taken: number, all: number, spent: number, telling: number, estimate?: Estimate): void {
  scope.postMessage({ op: "progress", run, taken, all, estimate, slice: spent, telling }, estimate ? [estimate.states.buffer] : []);
}

function refuse(id: number, error: unknown): void {
  const words = error instanceof Error ? error.message : String(error);
  scope.postMessage({ op: "refused", id, words, plain: error instanceof Refused });
}

function answer(id: number, call: () => unknown): void {
  try {
    const result = call();
    scope.postMessage({ op: "answer", id, result }, arrays(result));
  } catch (error) {
    refuse(id, error);
  }
}

function slice(engine: Engine): void {
  if (run < 0) return;
  const began = performance.now();
  try {
    let [taken, all, idle] = engine.step(0);
    while ((taken < all || !idle) && performance.now() - began < SLICE) {
      [taken, all, idle] = engine.advance(UNITS);
      if (idle && every > 0 && taken !== toldAt && taken % every === 0 && taken < all) {
        toldAt = taken;
        tell(taken, all, 0, 0, engine.estimate(SNAPSHOT_STATES));
      }
    }
    const spent = performance.now() - began;
    const over = idle && taken === all;
    const due = idle && finishing === undefined && taken !== toldAt && (over || (every === 0 && began - told > TOLD));
    const estimate = due ? engine.estimate(every > 0 ? SNAPSHOT_STATES : MOST_STATES) : undefined;
    const now = performance.now();
    if (due) [told, toldAt] = [now, taken];
    tell(idle ? taken : taken - 1, all, spent, now - began - spent, estimate);
    if (!over) return schedule();
    if (finishing !== undefined) {
      const id = finishing;
      finishing = undefined;
      answer(id, () => engine.finish());
    }
  } catch (error) {
    const words = error instanceof Error ? error.message : String(error);
    scope.postMessage({ op: "progress", run, taken: 0, all: 0, slice: 0, telling: 0, failed: words });
    run = -1;
    if (finishing !== undefined) refuse(finishing, error);
    finishing = undefined;
  }
}

scope.onmessage = ({ data }: MessageEvent<Request>) => {
  if (data.op === "module") {
    engine = Engine.of(data.module);
    return;
  }
  void engine.then((engine) => {
    if (data.op === "follow") {
      if (finishing !== undefined) refuse(finishing, new Error("another run has begun"));
      finishing = undefined;
      run = data.run;
      every = data.every;
      told = 0;
      toldAt = -1;
      schedule();
      return;
    }
    if (data.name === "finish" && run >= 0) {
      try {
        engine.endRows();
        finishing = data.id;
        schedule();
      } catch (error) {
        refuse(data.id, error);
      }
      return;
    }
    answer(data.id, () => {
      const call = (engine as unknown as Record<string, (...args: unknown[]) => unknown>)[data.name];
      return call.apply(engine, data.args);
    });
    if (data.name === "addRows") schedule();
  });
};
