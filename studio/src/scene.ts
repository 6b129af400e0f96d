// What a scene is, and what it is given.

import type { Engine } from "./engine";
import type { Remote } from "./remote";

export type State = Record<string, string>;

export interface Stage {
  /** The library on this thread. */
  engine: Engine;
  /** A fresh library on this thread, or in a worker; workers end with the scene. */
  freshEngine(): Promise<Engine>;
  worker(): Remote;
  /** Where the figure stands, and where the controls do. */
  figure: HTMLElement;
  panel: HTMLElement;
  /** What the link carries. */
  state: State;
  /** Says that the state has changed. */
  changed(state: State): void;
  announce(words: string): void;
}

export interface Running {
  end(): void;
  /** The scene's answers with what they answer, for the comparison with the command. */
  answers(): unknown;
  /** Draws all anew, as after a change of colours. */
  redraw(): void;
  /** The figure as an SVG file. */
  picture?(): string;
  /** How long things took, where the scene notes it; cheap to ask. */
  timings?(): unknown;
}

export interface Scene {
  id: string;
  tab: string;
  title: string;
  lead: string;
  start(stage: Stage): Promise<Running> | Running;
}

export function number(state: State, key: string, fallback: number): number {
  const value = Number(state[key] ?? NaN);
  return Number.isFinite(value) ? value : fallback;
}

export const still = (): boolean => matchMedia("(prefers-reduced-motion: reduce)").matches;

/** Runs at most once a frame, however often it is asked. */
export function onceAFrame(work: () => void): { (): void; cancel(): void } {
  let asked = 0;
  const ask = () => {
    asked ||= requestAnimationFrame(() => {
      asked = 0;
      work();
    });
  };
  ask.cancel = () => {
    cancelAnimationFrame(asked);
    asked = 0;
  };
  return ask;
}
