// A drive as the link carries it: poses now and then, as differences in whole steps, zigzag, by five bits a letter.

/** A pose at a time: t (s), x, y (m), theta (rad). */
export type Knot = [number, number, number, number];

/** Steps of time (s), place (m) and heading (rad), and the longest drive that a link carries. */
const STEPS = [1 / 150, 1e-4, 1e-4, 2e-3];
const MOST = 1200;
const LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";

const whole = (knot: Knot): number[] => knot.map((v, i) => Math.round(v / STEPS[i]));

/** The drive in letters; none where it is too long. */
export function written(knots: Knot[]): string | undefined {
  if (knots.length > MOST) return undefined;
  let before = [0, 0, 0, 0];
  let letters = "";
  for (const knot of knots) {
    const now = whole(knot);
    now.forEach((v, i) => {
      const difference = v - before[i];
      let rest = difference < 0 ? -2 * difference - 1 : 2 * difference;
      for (; rest > 31; rest = Math.floor(rest / 32)) letters += LETTERS[32 + (rest % 32)];
      letters += LETTERS[rest];
    });
    before = now;
  }
  return letters;
}

/** The poses of a drive; as many as make sense. */
export function read(letters: string): Knot[] {
  const knots: Knot[] = [];
  const now = [0, 0, 0, 0];
  let [axis, value, scale] = [0, 0, 1];
  for (const letter of letters.slice(0, 16 * MOST)) {
    const digit = LETTERS.indexOf(letter);
    if (digit < 0) break;
    value += (digit % 32) * scale;
    scale *= 32;
    if (digit > 31) continue;
    now[axis] += value % 2 ? -(value + 1) / 2 : value / 2;
    [axis, value, scale] = [(axis + 1) % 4, 0, 1];
    if (axis === 0) knots.push(now.map((v, i) => v * STEPS[i]) as Knot);
  }
  return knots.filter((knot, i) => knot.every(Number.isFinite) && (i === 0 || knot[0] > knots[i - 1][0]));
}
