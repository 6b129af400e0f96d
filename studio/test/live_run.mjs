// A run as `vibrissa live --view` tells it, by docs/live.md: a robot with two whiskers, frames that are lost, a pause.

const TOPICS = ["lines", "estimate", "whiskers", "readings", "health"];
const BEGAN = 1732450000;
/** Estimates, rows between two of them, and the step at which the sensor is silent for a while. */
const COUNT = 60;
const ROWS = 15;
const SILENT = 30;
const LENGTH = 0.075;

/** A whisker that is bent by `bend` (m at its tip), in the robot's frame. */
function shape(side, bend) {
  return Array.from({ length: 25 }, (_, i) => {
    const u = i / 24;
    const [along, across] = [LENGTH * u * (1 - 0.3 * Math.abs(bend / LENGTH) * u), bend * u * u];
    return [-0.35 * along + 0.94 * side * across - 0.01, side * (0.94 * along) + 0.35 * across];
  });
}

const placed = ({ x, y, theta }, [u, v]) => [x + Math.cos(theta) * u - Math.sin(theta) * v, y + Math.sin(theta) * u + Math.cos(theta) * v];

/** What is told of each estimate, and where its whiskers end on the map. */
export const STEPS = Array.from({ length: COUNT }, (_, k) => {
  const t = BEGAN + 0.05 * k + (k >= SILENT ? 0.4 : 0);
  const pose = { x: 0.12 + 0.004 * k, y: 0.2, theta: 0.1 * Math.sin(k / 9) };
  const bends = [0.018 * Math.max(0, Math.sin(k / 7)), -0.006];
  const shapes = bends.map((bend, side) => shape(side ? -1 : 1, bend));
  const moments = bends.map((bend) => 0.12 * bend);
  const extent = { x_min: pose.x - 1e-3, x_max: pose.x + 1e-3, y_min: pose.y - 1e-3, y_max: pose.y + 1e-3, theta_min: pose.theta - 0.01, theta_max: pose.theta + 0.01 };
  const reading = (name, side) => ({ column: `${name}.moment`, unit: "N m", value: moments[side], bound: 1e-4, expected: side ? null : moments[0] * 0.98 });
  const whiskers = ["left", "right"].map((name, side) => ({
    name, mount: { x: -0.01, y: 0, theta: side ? -1.9 : 1.9 }, length: LENGTH, touching: bends[side] !== 0,
    readings: [reading(name, side)], from: side ? "reading" : bends[0] ? "map" : "rest", shape: shapes[side],
    contact: !side && bends[0] ? shapes[0].at(-1) : null,
  }));
  const times = Array.from({ length: ROWS }, (_, i) => t - 0.05 + (0.05 * (i + 1)) / ROWS);
  const wave = (side) => times.map((_, i) => moments[side] + 2e-5 * Math.sin(3 * i));
  const missing = k >= SILENT ? 3 : 0;
  return {
    t,
    tips: shapes.map((points) => placed(pose, points.at(-1))),
    estimate: { t, rows: ROWS * (k + 1), status: k > 12 ? "localized" : "ambiguous", pose, count: 1, places: [{ ...pose, weight: 1, ...extent }] },
    whiskers: { t, pose, carried: 0, whiskers },
    readings: { columns: ["left.moment", "right.moment"], units: ["N m", "N m"], t: times, values: [wave(0), wave(1)] },
    health: {
      rows: ROWS * (k + 1), merged: 0, missing, not_recorded: 0, latency_p99: 0.0021, estimate_p99: 0.012, disk: null,
      sources: [{ name: "whiskers", lost: missing ? 2 : 0, damaged: 0, torn: 0, late: 0, unjoined: missing ? 1 : 0, uncalibrated: 0, missing }],
    },
  };
});

/** A room as lines of a visualization_msgs/MarkerArray in CDR. */
function lines() {
  const bytes = [0, 1, 0, 0];
  const align = (size) => {
    while ((bytes.length - 4) % size) bytes.push(0);
  };
  const put = (size, method, value) => {
    align(size);
    const view = new DataView(new ArrayBuffer(size));
    view[method](0, value, true);
    bytes.push(...new Uint8Array(view.buffer));
  };
  const u32 = (value) => put(4, "setUint32", value);
  const f64 = (value) => put(8, "setFloat64", value);
  const text = (words) => {
    u32(words.length + 1);
    bytes.push(...new TextEncoder().encode(words), 0);
  };
  const times = (count, work) => Array.from({ length: count }, work);
  u32(1);
  u32(0); u32(0); text("map"); text("map");
  u32(0); u32(4); u32(0);
  times(10, () => f64(0));
  times(4, () => put(4, "setFloat32", 1));
  u32(0); u32(0);
  bytes.push(0);
  const room = [[0.05, 0.1], [0.45, 0.1], [0.45, 0.28], [0.3, 0.28], [0.28, 0.25], [0.05, 0.28], [0.05, 0.1]];
  u32(room.length);
  room.forEach(([x, y]) => [x, y, 0].forEach(f64));
  u32(0);
  text(""); u32(0); u32(0); text(""); text(""); u32(0); u32(0); text(""); text(""); text(""); u32(0);
  bytes.push(0);
  return Buffer.from(bytes);
}

/** Plays the run to whatever asks at a port of this machine. */
export async function feed(page, port) {
  await page.routeWebSocket(`ws://127.0.0.1:${port}/`, (socket) => {
    socket.onMessage((message) => {
      const { op, subscriptions = [] } = JSON.parse(String(message));
      if (op !== "subscribe") return;
      const send = (topic, body) => {
        const subscription = subscriptions.find(({ channelId }) => channelId === TOPICS.indexOf(topic) + 1);
        if (!subscription) return;
        const head = Buffer.alloc(13);
        head.writeUInt8(1, 0);
        head.writeUInt32LE(subscription.id, 1);
        socket.send(Buffer.concat([head, body]));
      };
      send("lines", lines());
      for (const step of STEPS) {
        for (const topic of TOPICS.slice(1)) send(topic, Buffer.from(JSON.stringify(step[topic])));
      }
    });
    socket.send(JSON.stringify({ op: "serverInfo", name: "vibrissa live" }));
    socket.send(JSON.stringify({ op: "advertise", channels: TOPICS.map((name, i) => ({ id: i + 1, topic: `/vibrissa/${name}` })) }));
  });
}
