// Chromium without a window, and the command beside it.
import { execFileSync, spawnSync } from "node:child_process";
import { mkdtempSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { chromium } from "playwright-core";

/** Nothing but the page itself asks the network for anything. */
const FLAGS = [
  "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
  "--disable-component-update", "--disable-sync",
];

export async function open(executablePath, options = {}) {
  const context = await chromium.launchPersistentContext(mkdtempSync(join(tmpdir(), "studio-")), {
    executablePath, headless: true, args: FLAGS, viewport: { width: 1280, height: 800 }, ...options,
  });
  const page = context.pages()[0];
  const faults = [];
  page.on("pageerror", (error) => faults.push(error.message));
  page.on("console", (message) => message.type() === "error" && faults.push(message.text()));
  return { context, page, faults };
}

/** Goes to a scene and waits until it stands. */
export async function scene(page, base, hash) {
  await page.goto("about:blank");
  await page.goto(`${base}#${hash}`);
  const id = hash.split("?")[0];
  await page.waitForFunction((name) => document.documentElement.dataset.ready === name, id, { timeout: 30000 });
}

export const answers = (page) => page.evaluate(() => window.studio.answers());

/** Waits until the scene's answers satisfy a condition. */
export async function until(page, condition, limit = 60000) {
  const end = Date.now() + limit;
  for (;;) {
    const found = await answers(page);
    if (condition(found)) return found;
    if (Date.now() > end) throw new Error("the scene did not come to an end");
    await page.waitForTimeout(200);
  }
}

/** Waits until the robot of *Shrinking set* has driven its way and all its rows are taken; asking is cheap. */
export const driven = (page) => page.waitForFunction(() => window.studio.timings().done, undefined, { timeout: 120000, polling: 250 });

export class Command {
  constructor(program) {
    this.program = program;
    this.folder = mkdtempSync(join(tmpdir(), "studio-command-"));
  }
  /** The JSON that a command prints. */
  json(...args) {
    return JSON.parse(execFileSync(this.program, [...args, "--json"], { cwd: this.folder, encoding: "utf8", maxBuffer: 1 << 28, stdio: ["ignore", "pipe", "ignore"] }));
  }
  /** What a command that refuses says. */
  complaint(...args) {
    const { status, stderr } = spawnSync(this.program, args, { cwd: this.folder, encoding: "utf8" });
    const line = stderr.split("\n").find((one) => one.startsWith("error: ")) ?? "";
    return { status, words: stderr.slice(stderr.indexOf(line) + "error: ".length).trim() };
  }
}

let checked = 0;
let worst = 0;
/** The largest difference of page and command that is the same: relative, or absolute below 1. */
const SAME = 1e-9;

export function same(what, found, expected) {
  checked += 1;
  if (typeof expected === "number" && typeof found === "number") {
    const off = Math.abs(found - expected) / Math.max(1, Math.abs(expected));
    if (!(off <= SAME)) throw new Error(`${what}: the page says ${found}, the command ${expected}`);
    worst = Math.max(worst, off);
  } else if (found !== expected) {
    throw new Error(`${what}: the page says ${JSON.stringify(found)}, the command ${JSON.stringify(expected)}`);
  }
}

export const compared = () => ({ checked, worst });
