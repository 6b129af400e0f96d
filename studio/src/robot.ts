// How robots, places and states are drawn on a map, and how a robot stays clear of walls.

import type { BentWhisker, Estimate, Outline, Place, Point } from "./engine";
import { colour, type Plot } from "./plot";
import type { Pose } from "./rooms";

/** Radius of the drawn robot, and how close its middle may come to a wall (m). */
export const BODY = 0.011;
const CLEAR = 0.013;
/** States beyond these have no heading drawn. */
const MOST_TICKS = 1200;

export function drawRobot(plot: Plot, layer: string, pose: Pose, kind: string): void {
  plot.line(layer, outline(pose), kind, true);
}

/** The outline of a robot at a pose. */
export function outline([x, y, theta]: Pose): Point[] {
  const [c, s] = [Math.cos(theta), Math.sin(theta)];
  const place = (u: number, v: number): Point => [x + BODY * (c * u - s * v), y + BODY * (s * u + c * v)];
  const body: Point[] = [];
  for (let i = 0; i <= 20; i++) {
    const a = 0.75 + (i / 20) * (2 * Math.PI - 1.5);
    body.push(place(Math.cos(a), Math.sin(a)));
  }
  body.push(place(1.55, 0));
  return body;
}

export function drawStates(plot: Plot, states: Float64Array): void {
  const pen = plot.pen();
  const count = states.length / 3;
  if (!count) return;
  const ink = colour("set");
  pen.fillStyle = ink;
  pen.strokeStyle = ink;
  pen.globalAlpha = Math.min(0.9, Math.max(0.22, 60 / Math.sqrt(count) / 10));
  pen.lineWidth = 1;
  pen.beginPath();
  for (let i = 0; i < states.length; i += 3) {
    const [x, y] = plot.at([states[i], states[i + 1]]);
    pen.rect(x - 1.1, y - 1.1, 2.2, 2.2);
  }
  pen.fill();
  if (count > MOST_TICKS) return;
  pen.beginPath();
  for (let i = 0; i < states.length; i += 3) {
    const [x, y] = plot.at([states[i], states[i + 1]]);
    pen.moveTo(x, y);
    pen.lineTo(x + 8 * Math.cos(states[i + 2]), y - 8 * Math.sin(states[i + 2]));
  }
  pen.stroke();
}

/** States as a path of squares, for a picture: at most so many of them. */
export function statesPath(plot: Plot, states: Float64Array, most = 1500): { path: string; opacity: number } {
  const count = states.length / 3;
  const step = Math.max(1, Math.ceil(count / most));
  const words: string[] = [];
  for (let i = 0; i < count; i += step) {
    const [x, y] = plot.at([states[3 * i], states[3 * i + 1]]);
    words.push(`M${(x - 1.1).toFixed(1)} ${(y - 1.1).toFixed(1)}h2.2v2.2h-2.2z`);
  }
  return { path: words.join(""), opacity: 0.7 };
}

/** Whiskers as they bend; broken lines where their readings alone tell. */
export function drawWhiskers(plot: Plot, layer: string, whiskers: BentWhisker[]): void {
  for (const { from, contact, shape } of whiskers) {
    plot.line(layer, shape, `whisker thin${from === "reading" ? " supposed" : ""}`);
    if (from === "map") plot.dot(layer, contact, 3, "contact");
  }
}

/** An estimate carried on by odometry from one pose to another: each state moves as the wheels tell, in its own direction. */
export function carried({ states, places }: Pick<Estimate, "states" | "places">, from: Pose, to: Pose): Pick<Estimate, "states" | "places"> {
  const [dx, dy] = [to[0] - from[0], to[1] - from[1]];
  const [cos, sin] = [Math.cos(from[2]), Math.sin(from[2])];
  const [ahead, aside, turn] = [cos * dx + sin * dy, cos * dy - sin * dx, to[2] - from[2]];
  const moved = (x: number, y: number, theta: number): Pose => {
    const [c, s] = [Math.cos(theta), Math.sin(theta)];
    return [x + c * ahead - s * aside, y + s * ahead + c * aside, theta + turn];
  };
  const all = new Float64Array(states.length);
  for (let i = 0; i < states.length; i += 3) all.set(moved(states[i], states[i + 1], states[i + 2]), i);
  return {
    states: all,
    places: places.map((place) => {
      const [x, y, theta] = moved(place.x, place.y, place.theta);
      return { ...place, x, y, theta };
    }),
  };
}

/** Places with their weights, the best as a robot. */
export function drawPlaces(plot: Plot, layer: string, places: Place[]): void {
  places.slice(0, 60).forEach((place, index) => {
    drawRobot(plot, layer, [place.x, place.y, place.theta], index === 0 ? "found best" : "found");
    if (places.length > 1 && place.weight >= 0.02 && places.length <= 12) {
      plot.words(layer, [place.x, place.y], `${Math.round(100 * place.weight)}\u202f%`, "weight", [BODY / plot.pixel + 8, 4]);
    }
  });
}

/** What an estimate says, in a sentence; `all` is how many places there are where not all of them are told. */
export function verdictWords(estimate: Estimate | undefined, all = 0): { badge: string; kind: string; words: string } {
  if (!estimate || estimate.verdict === "no_contact") {
    return { badge: "no contact yet", kind: "", words: "Nothing has been touched: the robot can be anywhere." };
  }
  const count = Math.max(all, estimate.places.length);
  if (estimate.verdict === "inconsistent") {
    return { badge: "contradiction", kind: "bad", words: "No place explains the readings: something is not as declared." };
  }
  if (estimate.verdict === "localized") {
    return { badge: "localized", kind: "good", words: "One place is left." };
  }
  return count
    ? { badge: `${count} ${count === 1 ? "place" : "places"}`, kind: "open", words: `${count === 1 ? "One place explains" : `${count} places explain`} the readings so far, not yet surely.` }
    : { badge: "ambiguous", kind: "open", words: "Too little was felt to tell any place." };
}

/** The pose moved so far out of walls that its middle stays clear of them. */
export function clearOf(outlines: Outline[], [x, y, theta]: Pose): Pose {
  for (let round = 0; round < 3; round++) {
    const [wx, wy] = wallNear(outlines, [x, y]);
    const distance = Math.hypot(x - wx, y - wy);
    if (!(distance < CLEAR && distance > 1e-9)) break;
    const share = CLEAR / distance - 1;
    [x, y] = [x + share * (x - wx), y + share * (y - wy)];
  }
  return [x, y, theta];
}

/** The nearest point of the walls. */
export function wallNear(outlines: Outline[], [x, y]: Point): Point {
  let nearest: Point = [Infinity, Infinity];
  let least = Infinity;
  for (const { points, closed } of outlines) {
    for (let i = closed ? 0 : 1; i < points.length; i++) {
      const [a, b] = [points[(i || points.length) - 1], points[i]];
      const [dx, dy] = [b[0] - a[0], b[1] - a[1]];
      const share = Math.min(1, Math.max(0, ((x - a[0]) * dx + (y - a[1]) * dy) / (dx * dx + dy * dy || 1)));
      const at: Point = [a[0] + share * dx, a[1] + share * dy];
      const distance = Math.hypot(x - at[0], y - at[1]);
      if (distance < least) [least, nearest] = [distance, at];
    }
  }
  return nearest;
}

/** Whether a point is inside a ring. */
export function inside(ring: Point[], [x, y]: Point): boolean {
  let odd = false;
  ring.forEach(([ax, ay], i) => {
    const [bx, by] = ring[(i || ring.length) - 1];
    if (ay > y !== by > y && x < ax + ((y - ay) / (by - ay)) * (bx - ax)) odd = !odd;
  });
  return odd;
}
