// Frames and slices while a robot is localized, beside those of an empty page. Usage: node frames.mjs PAGE.html
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { driven, open, scene } from "./browser.mjs";

const EMPTY = 5000;
const ROOMS = [["arena", "probabilistic"], ["square", "possibilistic"], ["arena", "deterministic"]];

/** Median, 99 % and largest (ms). */
export function spread(values) {
  const sorted = [...values].sort((a, b) => a - b);
  const at = (share) => (sorted.length ? sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))] : NaN);
  return `${at(0.5).toFixed(1)} median, ${at(0.99).toFixed(1)} at 99 %, ${at(1).toFixed(1)} at most`;
}

/** The gaps between frames of a page that does nothing (ms). */
const empty = (page, during) => page.evaluate((limit) => new Promise((done) => {
  const gaps = [];
  const began = performance.now();
  let last = began;
  requestAnimationFrame(function frame(now) {
    gaps.push(now - last);
    last = now;
    if (now - began < limit) requestAnimationFrame(frame);
    else done(gaps);
  });
}), during);

export async function frames(page, base) {
  const told = [];
  const bare = async () => {
    await page.goto("about:blank");
    told.push(`empty page: frames ${spread(await empty(page, EMPTY))} ms`);
  };
  for (const [room, method] of ROOMS) {
    await bare();
    await scene(page, base, `shrink?room=${room}&method=${method}`);
    await driven(page);
    const { frames, work, slices, estimates, rows } = await page.evaluate(() => window.studio.timings());
    told.push(
      `${method} in ${room}, ${rows} rows: frames ${spread(frames)} ms; the page's own work in them ${spread(work)} ms; `
      + `slices of the worker ${spread(slices)} ms; estimates ${spread(estimates)} ms`,
    );
  }
  await bare();
  return told;
}

if (process.argv[1] === new URL(import.meta.url).pathname) {
  const { context, page } = await open(process.env.CHROMIUM ?? "/usr/bin/chromium");
  (await frames(page, pathToFileURL(resolve(process.argv[2])).href)).forEach((line) => console.log(line));
  await context.close();
}
