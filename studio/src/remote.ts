// A library in a worker, as the page calls it.

import { Refused, type Engine, type Estimate } from "./engine";
import type { Reply, Request } from "./worker";

type Method<K extends keyof Engine> = Engine[K] extends (...args: infer A) => infer R ? (...args: A) => Promise<R> : never;

export interface Progress {
  taken: number;
  all: number;
  estimate?: Estimate;
  /** How long the slice took (ms). */
  slice: number;
  /** And how long it took to tell the estimate (ms). */
  telling: number;
  failed?: string;
}

declare const WORKER_SOURCE: string;
let address: string | undefined;

export class Remote {
  private readonly worker: Worker;
  private readonly waiting = new Map<number, { resolve(value: unknown): void; reject(error: Error): void }>();
  private next = 0;
  private run = 0;
  private watch?: (progress: Progress) => void;

  constructor(module: WebAssembly.Module) {
    address ??= URL.createObjectURL(new Blob([WORKER_SOURCE], { type: "text/javascript" }));
    this.worker = new Worker(address);
    this.worker.onmessage = ({ data }: MessageEvent<Reply>) => this.heard(data);
    this.post({ op: "module", module });
  }

  private post(request: Request): void {
    this.worker.postMessage(request);
  }

  private heard(reply: Reply): void {
    if (reply.op === "progress") {
      if (reply.run === this.run) this.watch?.(reply);
      return;
    }
    const waiting = this.waiting.get(reply.id);
    this.waiting.delete(reply.id);
    if (reply.op === "answer") waiting?.resolve(reply.result);
    else waiting?.reject(reply.plain ? new Refused(reply.words) : new Error(reply.words));
  }

  /** Calls a function of the library in the worker. */
  call<K extends keyof Engine>(name: K, ...args: Parameters<Method<K>>): ReturnType<Method<K>> {
    const id = this.next++;
    const answer = new Promise((resolve, reject) => this.waiting.set(id, { resolve, reject }));
    this.post({ op: "call", id, name, args });
    return answer as ReturnType<Method<K>>;
  }

  /** Localizes by a method on what was read; rows are taken as they come, in slices. */
  async localize(method: string, watch: (progress: Progress) => void, every = 0): Promise<void> {
    this.run += 1;
    const run = this.run;
    await this.call("beginLocalize", method);
    if (run !== this.run) return;
    this.watch = watch;
    this.post({ op: "follow", run, every });
  }

  end(): void {
    this.worker.terminate();
  }
}
