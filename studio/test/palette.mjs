// Whether the colours of the page are told apart by those who see all colours, and by each kind of the colour-blind.
// Usage: node studio/test/palette.mjs

import { readFileSync } from "node:fs";

/** What is drawn beside each other, by the names in style.css, and what it stands on. */
const INKS = ["touch", "set", "truth", "ink"];
const GROUND = "card";
/** Least distance of two colours (CIEDE76 in L*a*b*): where it is below 10 people mistake thin lines of them. */
const APART = 15;
/** Least contrast of a line and what it stands on (WCAG 2.2, graphics). */
const CONTRAST = 3;

/** How sRGB light looks without one kind of cone (Machado, Oliveira and Fernandes 2009, full severity), on linear light. */
const SIGHT = {
  "all cones": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
  "no long cones": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
  "no middle cones": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.01182, 0.04294, 0.968881]],
  "no short cones": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.3039]],
};

const light = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16) / 255).map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4));
const seen = (matrix, rgb) => matrix.map((row) => Math.min(1, Math.max(0, row.reduce((sum, m, i) => sum + m * rgb[i], 0))));
const brightness = ([r, g, b]) => 0.2126 * r + 0.7152 * g + 0.0722 * b;
const contrast = (a, b) => (Math.max(brightness(a), brightness(b)) + 0.05) / (Math.min(brightness(a), brightness(b)) + 0.05);

/** L*a*b* of linear sRGB at D65. */
function lab([r, g, b]) {
  const xyz = [
    (0.4124564 * r + 0.3575761 * g + 0.1804375 * b) / 0.95047,
    0.2126729 * r + 0.7151522 * g + 0.072175 * b,
    (0.0193339 * r + 0.119192 * g + 0.9503041 * b) / 1.08883,
  ];
  const [x, y, z] = xyz.map((t) => (t > 216 / 24389 ? Math.cbrt(t) : (24389 / 27 * t + 16) / 116));
  return [116 * y - 16, 500 * (x - y), 200 * (y - z)];
}

const distance = (a, b) => Math.hypot(...lab(a).map((v, i) => v - lab(b)[i]));

/** The colours of a theme, by name. */
function theme(css, selector) {
  const at = css.indexOf(`${selector} {`);
  if (at < 0) throw new Error(`style.css has no ${selector}`);
  const block = css.slice(at, css.indexOf("}", at));
  return Object.fromEntries([...block.matchAll(/--([a-z-]+): (#[0-9a-f]{6});/g)].map(([, name, hex]) => [name, light(hex)]));
}

const css = readFileSync(new URL("../src/style.css", import.meta.url), "utf8");
const faults = [];
for (const [name, selector] of [["light", ":root"], ["dark", ":root[data-theme=dark]"]]) {
  const colours = theme(css, selector);
  for (const [sight, matrix] of Object.entries(SIGHT)) {
    const [ground, ...inks] = [GROUND, ...INKS].map((ink) => seen(matrix, colours[ink]));
    let least = Infinity;
    inks.forEach((ink, i) => {
      const on = contrast(ink, ground);
      if (!(on >= CONTRAST)) faults.push(`${name}, ${sight}: ${INKS[i]} has a contrast of ${on.toFixed(2)} only`);
      for (let k = 0; k < i; k++) {
        const apart = distance(ink, inks[k]);
        least = Math.min(least, apart);
        if (!(apart >= APART)) faults.push(`${name}, ${sight}: ${INKS[k]} and ${INKS[i]} are ${apart.toFixed(1)} apart only`);
      }
    });
    console.log(`${name.padEnd(6)} ${sight.padEnd(16)} ${least.toFixed(1).padStart(5)} apart at least`);
  }
}
if (faults.length) {
  console.error(faults.join("\n"));
  process.exit(1);
}
