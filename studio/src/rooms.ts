// The rooms and the robot that the scenes start with.

import arena from "../../crates/vibrissa/data/demo_arena.svg";
import corridor from "../../scenarios/maps/corridor.svg";
import room from "../../scenarios/maps/room.svg";
import { boxOf, type Box } from "./plot";
import type { Outline, Point, RoomMap } from "./engine";
import { inside, wallNear } from "./robot";

export type Pose = [number, number, number];

export interface Room {
  id: string;
  words: string;
  file: string;
  map: string;
  start: Pose;
  /** The way that the robot takes by itself: x, y (m), heading (degrees). */
  way: Pose[];
}

/** A room with these corners (m), as GeoJSON. */
export const polygon = (ring: Point[]): string => JSON.stringify({
  type: "FeatureCollection",
  features: [{ type: "Feature", properties: { role: "arena" }, geometry: { type: "Polygon", coordinates: [[...ring, ring[0]]] } }],
});
const square = polygon([[0, 0], [0.4, 0], [0.4, 0.4], [0, 0.4]]);

export const ROOMS: Room[] = [
  {
    id: "arena", words: "arena", file: "arena.svg", map: arena, start: [0.104, 0.236, 0],
    way: [[0.104, 0.236, 0], [0.166, 0.262, 0], [0.211, 0.273, 0], [0.256, 0.262, -2], [0.296, 0.25, -4], [0.35, 0.239, -4], [0.395, 0.243, -2]],
  },
  {
    id: "square", words: "square", file: "square.geojson", map: square, start: [0.12, 0.32, 0],
    way: [[0.12, 0.32, 0], [0.18, 0.352, 0], [0.31, 0.352, 0], [0.345, 0.3, -60], [0.352, 0.24, -90], [0.352, 0.1, -90]],
  },
  {
    id: "corridor", words: "corridor", file: "corridor.svg", map: corridor, start: [0.16, 0.15, 0],
    way: [[0.16, 0.15, 0], [0.2, 0.17, 0], [0.3, 0.176, 0], [0.45, 0.176, 0], [0.6, 0.176, 0], [0.76, 0.176, 0]],
  },
  {
    id: "room", words: "room", file: "room.svg", map: room, start: [0.2, 0.6, 0],
    way: [[0.2, 0.6, 0], [0.3, 0.645, 0], [0.6, 0.645, 0], [0.88, 0.64, 0]],
  },
];

export const roomOf = (id: string | undefined): Room => ROOMS.find((room) => room.id === id) ?? ROOMS[0];

/** A room that somebody has drawn, by its corners in millimetres; the robot starts where the walls are farthest. */
export function drawnRoom(ring: string): Room | undefined {
  const numbers = ring.split("_").map((v) => Number(v) / 1000);
  const points = Array.from({ length: Math.floor(numbers.length / 2) }, (_, i): Point => [numbers[2 * i], numbers[2 * i + 1]]);
  if (points.length < 3 || points.length > 200 || !numbers.every((v) => Math.abs(v) < 100)) return undefined;
  const walls: Outline[] = [{ role: "arena", closed: true, points }];
  const box = boxOf(points, 0);
  let best: Pose = [...points[0], 0];
  let farthest = 0;
  for (let i = 1; i < 40; i++) {
    for (let k = 1; k < 40; k++) {
      const at: Point = [box.left + (i / 40) * (box.right - box.left), box.bottom + (k / 40) * (box.top - box.bottom)];
      const [x, y] = wallNear(walls, at);
      const far = inside(points, at) ? Math.hypot(x - at[0], y - at[1]) : 0;
      if (far > farthest) [farthest, best] = [far, [...at, 0]];
    }
  }
  return farthest > 0 ? { id: "drawn", words: "drawn", file: "drawn.geojson", map: polygon(points), start: best, way: [best] } : undefined;
}

/** What the map fills, with a margin (m). */
export function roomBox(map: RoomMap): Box {
  const points = map.outlines.flatMap((outline) => outline.points);
  const box = boxOf(points, 0);
  const margin = 0.03 * Math.max(box.right - box.left, box.top - box.bottom);
  const whole = boxOf(points, margin);
  // Below is room for the scale.
  return { ...whole, bottom: whole.bottom - 1.1 * margin };
}

/** A whisker that trails to the left, as the studio's robot has it, and bounds on its errors where they are declared. */
export function robotFile(declared: boolean): string {
  const bounds = declared ? 'zero_error = "0.5 mN m"\ngain_error = 0.2\n' : "";
  const odometry = declared ? "\n[odometry]\ntranslation_relative = 0.08\nrotation_relative = 0.08\n" : "";
  return `[[whisker]]\nname = "w0"\nmount = [0, 0, "128 deg"]\n${bounds}${odometry}`;
}

/** The mount's angle of that robot (rad). */
export const MOUNT = (128 / 180) * Math.PI;
