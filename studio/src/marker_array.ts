// The map of a run: a visualization_msgs/MarkerArray in CDR.

import type { Point } from "./engine";

/** The points of each marker of lines. */
export function markerLines(view: DataView): Point[][] {
  // Offsets count from behind the header of four bytes.
  let at = 4;
  const align = (size: number) => (at = 4 + Math.ceil((at - 4) / size) * size);
  const u32 = () => {
    align(4);
    at += 4;
    return view.getUint32(at - 4, true);
  };
  const f64 = () => {
    align(8);
    at += 8;
    return view.getFloat64(at - 8, true);
  };
  const skip = (size: number, count: number) => {
    if (count > 0) {
      align(size);
      at += size * count;
    }
  };
  const text = () => skip(1, u32());
  const lines: Point[][] = [];
  const markers = u32();
  for (let marker = 0; marker < markers; marker++) {
    u32();
    u32();
    text(); // header: stamp, frame
    text(); // namespace
    u32(); // id
    const kind = u32();
    u32(); // action
    skip(8, 7); // pose
    skip(8, 3); // scale
    skip(4, 4); // colour
    u32();
    u32(); // lifetime
    at += 1; // frame_locked
    const points: Point[] = [];
    const count = u32();
    for (let i = 0; i < count; i++) {
      points.push([f64(), f64()]);
      f64();
    }
    skip(4, 4 * u32()); // colours
    // A strip is one line, a list has two points for each.
    if (kind === 4) lines.push(points);
    else for (let i = 0; i + 1 < points.length; i += 2) lines.push([points[i], points[i + 1]]);
    text(); // texture's resource
    u32();
    u32();
    text(); // texture's header
    text();
    skip(1, u32()); // texture
    skip(4, 2 * u32()); // its coordinates
    text();
    text(); // mesh's resource
    text();
    skip(1, u32()); // mesh's file
    at += 1; // use of its materials
  }
  return lines;
}
