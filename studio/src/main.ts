// The page: scenes by tabs, one at a time; the link says which and how it stands.

import { Engine } from "./engine";
import { announcer, element } from "./controls";
import { decompress } from "./lzma";
import { forgetColours } from "./plot";
import { Remote } from "./remote";
import type { Running, Scene, State } from "./scene";
import { bend } from "./scenes/bend";
import { contact } from "./scenes/contact";
import { live } from "./scenes/live";
import { own } from "./scenes/own";
import { preimage } from "./scenes/preimage";
import { shrink } from "./scenes/shrink";

declare const LIBRARY: string;

const SCENES: Scene[] = [bend, contact, preimage, shrink, own, live];
/** How often the link is brought up to date (ms). */
const LINK = 300;

function library(): Promise<WebAssembly.Module> {
  const packed = Uint8Array.from(atob(LIBRARY), (c) => c.charCodeAt(0));
  return WebAssembly.compile(decompress(packed) as BufferSource);
}

interface Route {
  id: string;
  state: State;
}

function route(): Route {
  const [id, query = ""] = location.hash.slice(1).split("?");
  return { id, state: Object.fromEntries(new URLSearchParams(query)) };
}

class Page {
  private running: Running | undefined;
  private workers: Remote[] = [];
  private shown = "";
  private timer = 0;
  private embedded = false;
  private readonly whole = element("a", { class: "whole", target: "_blank", rel: "noopener" }, "Open in the studio");
  private readonly tabs = new Map<string, HTMLElement>();
  private readonly stage = document.getElementById("stage")!;
  private readonly announce: (words: string) => void;

  constructor(private readonly module: WebAssembly.Module, private readonly engine: Engine) {
    const list = document.getElementById("tabs")!;
    for (const scene of SCENES) {
      const link = element("a", { href: `#${scene.id}` }, scene.tab);
      list.append(element("li", {}, link));
      this.tabs.set(scene.id, link);
    }
    this.announce = announcer(document.body);
    document.body.append(this.whole);
    const theme = document.getElementById("theme")!;
    theme.addEventListener("click", () => {
      const dark = document.documentElement.dataset.theme
        ? document.documentElement.dataset.theme === "dark"
        : matchMedia("(prefers-color-scheme: dark)").matches;
      document.documentElement.dataset.theme = dark ? "light" : "dark";
      this.recolour();
    });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.recolour());
    document.getElementById("link")!.addEventListener("click", (event) => {
      const button = event.currentTarget as HTMLElement;
      void navigator.clipboard?.writeText(location.href).then(() => {
        button.classList.add("done");
        this.announce("link copied");
        setTimeout(() => button.classList.remove("done"), 1200);
      });
    });
    addEventListener("hashchange", () => void this.show());
  }

  /** Within another page the figure and its controls alone are shown, with a link to the whole. */
  private embed(state: State): void {
    this.embedded = "embed" in state;
    document.documentElement.toggleAttribute("data-embed", this.embedded);
    delete state.embed;
  }

  private recolour(): void {
    forgetColours();
    this.running?.redraw();
  }

  async show(): Promise<void> {
    const { id, state } = route();
    this.embed(state);
    const scene = SCENES.find((s) => s.id === id) ?? SCENES[0];
    const link = `${scene.id}?${new URLSearchParams(state)}`;
    if (link === this.shown) return;
    this.shown = link;
    this.running?.end();
    this.running = undefined;
    this.workers.forEach((worker) => worker.end());
    this.workers = [];
    this.tabs.forEach((tab, name) => (name === scene.id ? tab.setAttribute("aria-current", "page") : tab.removeAttribute("aria-current")));
    this.tabs.get(scene.id)?.scrollIntoView({ inline: "center", block: "nearest" });
    document.title = `${scene.title} · vibrissa studio`;
    const figure = element("div", { class: "figure" });
    const panel = element("div", { class: "panel" });
    this.whole.href = `${location.href.split("#")[0]}#${link}`;
    this.stage.replaceChildren(
      element("header", { class: "head" }, element("h1", {}, scene.title), element("p", { class: "lead" }, scene.lead)),
      element("div", { class: "scene", "data-scene": scene.id }, figure, panel),
    );
    try {
      this.running = await scene.start({
        engine: this.engine,
        freshEngine: () => Engine.of(this.module),
        worker: () => {
          const worker = new Remote(this.module);
          this.workers.push(worker);
          return worker;
        },
        figure, panel, state,
        changed: (next) => this.link(scene, next),
        announce: this.announce,
      });
    } catch (error) {
      figure.replaceChildren(element("p", { class: "refused", role: "alert" }, error instanceof Error ? error.message : String(error)));
    }
    Object.assign(window, { studio: { scene: scene.id, answers: () => this.running?.answers(), timings: () => this.running?.timings?.(), picture: () => this.running?.picture?.() } });
    document.documentElement.dataset.ready = scene.id;
  }

  private link(scene: Scene, state: State): void {
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => {
      const query = new URLSearchParams(state).toString();
      this.shown = `${scene.id}?${query}`;
      this.whole.href = `${location.href.split("#")[0]}#${this.shown}`;
      if (this.embedded) return;
      history.replaceState(null, "", `#${scene.id}${query ? `?${query}` : ""}`);
    }, LINK);
  }
}

async function begin(): Promise<void> {
  const module = await library();
  const page = new Page(module, await Engine.of(module));
  await page.show();
  requestAnimationFrame(() => performance.mark("first-frame"));
}

begin().catch((error: unknown) => {
  const words = error instanceof Error ? error.message : String(error);
  document.getElementById("stage")!.replaceChildren(element("p", { class: "refused", role: "alert" }, `The page could not start: ${words}`));
});
