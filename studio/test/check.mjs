// Every scene's numbers against those of the command, in Chromium. Usage: node test/check.mjs VIBRISSA PAGE.html [--times] [--shots FOLDER]
import { spawn } from "node:child_process";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { networkInterfaces } from "node:os";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { Command, answers, compared, driven, open, same, scene, until } from "./browser.mjs";
import { frames } from "./frames.mjs";
import { STEPS, feed } from "./live_run.mjs";

const [program, file, ...rest] = process.argv.slice(2);
const shots = rest.includes("--shots") ? rest[rest.indexOf("--shots") + 1] : undefined;
const chromium = process.env.CHROMIUM ?? "/usr/bin/chromium";
const base = pathToFileURL(resolve(file)).href;
const command = new Command(resolve(program));
const write = (name, text) => writeFileSync(join(command.folder, name), text);
const METHODS = ["probabilistic", "possibilistic", "deterministic"];
const SCENES = ["bend", "contact", "preimage", "shrink", "own", "live"];
const { context, page, faults } = await open(chromium);

async function step(name, work) {
  const began = Date.now();
  await work();
  console.log(`${((Date.now() - began) / 1000).toFixed(1).padStart(6)} s  ${name}`);
}

/** Drags the scene's handle by so many pixels. */
async function drag(right, down) {
  const box = await page.locator(".handle.push").first().boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + right, y + down, { steps: 8 });
  await page.mouse.up();
}

function sameBends(found, expected) {
  same("equilibria", found.length, expected.length);
  found.forEach((bend, i) => {
    for (const key of ["force", "s_a", "phi_a", "beta", "x", "y", "moment", "energy"]) same(`beam ${key}`, bend[key], expected[i][key]);
    bend.shape.forEach((point, k) => point.forEach((v, axis) => same("beam shape", v, expected[i].shape[k][axis])));
    same("strain", bend.strain, expected[i].largest_strain.strain);
  });
}

await step("bend: a post and a force, dragged, against `beam`", async () => {
  await scene(page, base, "bend");
  for (const [right, down] of [[0, 0], [40, -30], [-120, 10], [60, 90]]) {
    await drag(right, down);
    const { mode, given, solutions } = await answers(page);
    same("mode", mode, "post");
    sameBends(solutions, command.json("beam", "point", "--x", `${given.x}`, "--y", `${given.y}`).solutions);
  }
  await scene(page, base, "bend?mode=force&f=-0.11&s=0.05");
  for (const [right, down] of [[0, 0], [-20, 50]]) {
    await drag(right, down);
    const { given, solutions } = await answers(page);
    sameBends(solutions, command.json("beam", "force", "--force", `${given.force}`, "--s-a", `${given.s_a}`).solutions);
  }
});

await step("bend: a wall, dragged, against `beam`", async () => {
  for (const [hash, right, down] of [["bend?mode=wall", 0, 0], ["bend?mode=wall&wx=0.03&wy=0.012&wa=-0.5", -5, 5]]) {
    await scene(page, base, hash);
    await drag(right, down);
    const { moment, touches, shape } = await answers(page);
    same("contacts", touches.length, 1);
    const [{ at, force, size, side }] = touches;
    same("on its side", side, false);
    const angle = Math.atan2(force[1], force[0]);
    const { solutions } = command.json("beam", "force", "--force", `${size}`, "--s-a", "0.075", "--load", `directed:${angle}`);
    const near = solutions.reduce((best, one) => (Math.abs(one.moment - moment) < Math.abs(best.moment - moment) ? one : best));
    same("moment", moment, near.moment);
    for (const key of ["s_a", "phi_a", "energy"]) same(`wall ${key}`, shape[key], near[key]);
    same("wall strain", shape.strain, near.largest_strain.strain);
    if ((await page.locator(".readout").innerText()).includes("–")) throw new Error("a number of the whisker at the wall is missing");
    at.forEach((v, axis) => same("contact", v, [near.x, near.y][axis]));
  }
});

await step("contact set: each sensor, against `contact-set`", async () => {
  for (const sensor of ["moment", "load", "slope", "strip"]) {
    await scene(page, base, `contact?sensor=${sensor}&error=6`);
    await drag(25, -20);
    const { value, error, set, region: found } = await until(page, (now) => now.ready);
    const exact = command.json("contact-set", "--sensor", sensor, "--value", `${value}`).curves[0];
    same("tolerance", set.tolerance, exact.tolerance);
    same("branches", set.curves.length, exact.branches.length);
    set.curves.forEach((curve, i) => {
      same("contacts", curve.length, exact.branches[i].length);
      curve.forEach((contact, k) => Object.entries(exact.branches[i][k]).forEach(([key, v]) => same(`contact ${key}`, contact[key], v)));
    });
    // Regions take the command a while: two kinds of them are enough.
    if (sensor === "load" || sensor === "slope") continue;
    const half = (Math.abs(value) * error) / 100;
    const { region } = command.json("contact-set", "--sensor", sensor, "--value", `${value - half}..${value + half}`);
    same("area", found.area, region.area);
    same("components", found.components, region.components);
    same("cells", found.cells.length, region.cells.length);
  }
});

await step("preimage: against `preimage`", async () => {
  for (const hash of ["preimage?room=arena&m=4&error=5", "preimage?room=square&m=-3&error=10"]) {
    await scene(page, base, hash);
    const { map, file: name, robot, lo, hi, cell, headings, found } = await answers(page);
    write(name, map);
    write("robot.toml", robot);
    const expected = command.json(
      "preimage", "--map", name, "--robot", "robot.toml", "--sensor", "moment", "--value", `${lo}..${hi}`,
      "--cell", `${cell}`, "--heading-step", `${(2 * Math.PI) / headings}`,
    );
    same("empty", found.empty, expected.empty);
    same("area", found.area, expected.area);
    same("sampled area", found.sampledArea, expected.sampled_area);
    same("volume", found.volume, expected.volume);
    same("deviation", found.deviation, expected.deviation);
  }
});

/** The same places; those that weigh alike may come in another order. */
function samePlaces(places, expected) {
  same("places", places.length, expected.hypotheses.length);
  const extents = ["x_min", "x_max", "y_min", "y_max", "theta_min", "theta_max"];
  const left = [...expected.hypotheses];
  for (const place of places) {
    const far = (one) => Math.hypot(one.x - place.x, one.y - place.y);
    const other = left.reduce((best, one) => (far(one) < far(best) ? one : best));
    left.splice(left.indexOf(other), 1);
    for (const key of ["x", "y", "theta", "weight"]) same(`place ${key}`, place[key], other[key]);
    extents.forEach((key, k) => same(`place ${key}`, place.extent[k], other[key]));
  }
}

function localized(method, { map, file: name, robot, log }, ...options) {
  write(name, map);
  write("robot.toml", robot);
  write("log.csv", log);
  return command.json("localize", "log.csv", "--map", name, "--robot", "robot.toml", "--method", method, ...options);
}

/** The same errors of what was declared. */
function sameNuisances(nuisances, expected) {
  same("nuisances", nuisances.length, expected.nuisances.length);
  expected.nuisances.forEach((one, k) => ["quantity", "whisker", "estimate", "std"].forEach((key) => same(`nuisance ${key}`, nuisances[k][key] ?? null, one[key] ?? null)));
}

/** What is told of them in words: those that are significant, of the method that is shown. */
function sameFelt(found) {
  const { nuisances } = found.answers.find((one) => one.method === "probabilistic");
  same("what was felt", found.felt.join("; "), nuisances.filter((one) => one.significant).map((one) => one.words).join("; "));
}

await step("shrinking set: driven by itself and by keys, against `localize`", async () => {
  for (const method of METHODS) {
    await scene(page, base, `shrink?room=${method === "possibilistic" ? "square" : "arena"}&method=${method}`);
    await driven(page);
    const found = await answers(page);
    const expected = localized(method, found);
    same("verdict", found.answer.verdict, expected.status);
    samePlaces(expected.status === "inconsistent" ? [] : found.answer.places, expected);
  }
  await scene(page, base, "shrink?room=arena");
  await page.locator(".robot-handle").focus();
  const rows = (found) => found.log.split("\n").length;
  await page.keyboard.down("w");
  await page.waitForTimeout(700);
  await page.keyboard.up("w");
  const before = rows(await until(page, (now) => now.waiting === 0));
  if (before < 40) throw new Error(`the keys moved the robot by ${before} rows only`);
});

await step("shrinking set: by touch, by gamepad, all methods side by side, and the drive again from the link", async () => {
  await scene(page, base, "shrink?room=square&method=possibilistic&all=1");
  const box = await page.locator(".robot-handle").boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  const touch = await page.context().newCDPSession(page);
  const finger = (type, at) => touch.send("Input.dispatchTouchEvent", { type, touchPoints: at ? [{ x: at[0], y: at[1] }] : [] });
  await finger("touchStart", [x, y]);
  for (let k = 1; k <= 12; k++) {
    await finger("touchMove", [x + 8 * k, y - 4 * k]);
    await page.waitForTimeout(60);
  }
  await finger("touchEnd");
  const touched = await until(page, (now) => now.waiting === 0 && now.log.split("\n").length > 60);
  await page.evaluate(() => {
    const pad = { axes: [0, -1, 0, 0], buttons: [], connected: true };
    navigator.getGamepads = () => [pad];
    window.pad = pad;
  });
  await page.waitForTimeout(600);
  await page.evaluate(() => (window.pad.axes = [0, 0, 0, 0]));
  await driven(page);
  await page.waitForTimeout(400);
  const before = await answers(page);
  const way = Math.hypot(before.pose[0] - touched.pose[0], before.pose[1] - touched.pose[1]);
  if (way < 0.02) throw new Error(`the gamepad moved the robot by ${way} m only`);
  same("methods", before.methods.map((one) => one.method).join(" "), METHODS.join(" "));
  const rows = before.log.trim().split("\n").length - 1;
  before.methods.forEach((one) => same(`rows of ${one.method}`, one.rows, rows));
  // The link is brought up to date now and then while one drives, and at each switch.
  await page.getByLabel("Hide the true robot").focus();
  await page.getByText("Sensor gain").click();
  await page.getByText("Sensor gain").click();
  await page.waitForTimeout(500);
  const link = await page.evaluate(() => location.hash.slice(1));
  await scene(page, base, link);
  await driven(page);
  const after = await answers(page);
  const off = Math.hypot(before.pose[0] - after.pose[0], before.pose[1] - after.pose[1]);
  if (!(off < 1e-3)) throw new Error(`the drive of the link ends ${off} m from where it did`);
  if (!(Math.abs(after.log.trim().split("\n").length - 1 - rows) < 0.1 * rows)) throw new Error("the drive of the link has another length");
});

await step("your own: a room drawn and driven in by keyboard alone; files dropped", async () => {
  await scene(page, base, "own");
  const press = async (...keys) => {
    for (const key of keys) await page.keyboard.press(key);
  };
  const tabTo = async (test) => {
    for (let k = 0; k < 80; k++) {
      await press("Tab");
      if (await page.evaluate(test)) return;
    }
    throw new Error(`the keyboard does not reach ${test}`);
  };
  await tabTo(() => document.activeElement.textContent === "Draw a room");
  await press("Enter");
  const times = (count, key) => Array.from({ length: count }, () => key);
  await press(...times(4, "Shift+ArrowLeft"), ...times(3, "Shift+ArrowDown"), "Enter", ...times(8, "Shift+ArrowRight"), "Enter");
  await press(...times(5, "Shift+ArrowUp"), "Enter", ...times(7, "Shift+ArrowLeft"), "Enter", "c");
  await until(page, (now) => now.file === "drawn.geojson");
  await press("Enter");
  await page.waitForFunction(() => document.documentElement.dataset.ready === "shrink");
  await tabTo(() => document.activeElement.classList.contains("robot-handle"));
  await page.keyboard.down("ArrowUp");
  await page.waitForTimeout(900);
  await page.keyboard.up("ArrowUp");
  await driven(page);
  const { map, log } = await answers(page);
  same("corners", JSON.parse(map).features[0].geometry.coordinates[0].length, 5);
  if (log.split("\n").length < 60) throw new Error("the keys did not drive the robot in the room that was drawn");
  await scene(page, base, "own");
  await until(page, (now) => now.ready);
  const dropped = (name, text) => page.evaluate(([name, text]) => {
    const carried = new DataTransfer();
    carried.items.add(new File([text], name));
    for (const type of ["dragover", "drop"]) window.dispatchEvent(new DragEvent(type, { dataTransfer: carried, bubbles: true, cancelable: true }));
  }, [name, text]);
  const bad = '[[whisker]]\nlength = "75 apples"\n';
  const good = await answers(page);
  [["good.svg", good.map], ["good.csv", good.log], ["dropped.toml", bad]].forEach(([name, text]) => write(name, text));
  const { words } = command.complaint("localize", "good.csv", "--map", "good.svg", "--robot", "dropped.toml");
  await dropped("dropped.toml", bad);
  const { refused } = await until(page, (now) => now.refused.includes("dropped.toml"), 10000).catch(() => answers(page));
  same("words about a file that is dropped", refused, words);
});

await step("`vibrissa studio` serves the page to who has its address, on the loopback alone", async () => {
  const served = spawn(resolve(program), ["studio", "--page", resolve(file)], { stdio: ["ignore", "pipe", "pipe"] });
  try {
    const address = await new Promise((done, failed) => {
      let printed = "";
      const heard = (data) => {
        printed += data;
        const [found] = /http:\S+/.exec(printed) ?? [];
        if (found) done(found);
      };
      served.stdout.on("data", heard);
      served.stderr.on("data", heard);
      served.on("exit", () => failed(new Error(`vibrissa studio ended: ${printed}`)));
    });
    const url = new URL(address);
    same("loopback", ["127.0.0.1", "localhost", "[::1]"].includes(url.hostname), true);
    same("with its address", (await fetch(address)).status, 200);
    for (const path of ["/", "/studio.html", `${url.pathname.slice(0, -2)}`]) {
      const { status } = await fetch(new URL(path, url));
      same(`status of ${path}`, status >= 400, true);
    }
    const outside = Object.values(networkInterfaces()).flat().find((one) => one.family === "IPv4" && !one.internal);
    if (outside) {
      const reached = await fetch(`http://${outside.address}:${url.port}${url.pathname}`, { signal: AbortSignal.timeout(2000) }).then(() => true, () => false);
      same("reached from outside", reached, false);
    }
    await page.goto(address);
    await page.waitForFunction(() => document.documentElement.dataset.ready);
  } finally {
    served.kill("SIGINT");
  }
});

await step("your own: each method against `localize`, and bad files in the command's words", async () => {
  await scene(page, base, "own");
  const found = await until(page, (now) => now.ready);
  for (const { method, verdict, places, nuisances, failed } of found.answers) {
    same("refused", failed, undefined);
    const expected = localized(method, found);
    same("verdict", verdict, expected.status);
    samePlaces(places, expected);
    sameNuisances(nuisances, expected);
  }
  sameFelt(found);
  // A robot that is taken for exactly what it declares is another one.
  await page.getByText("Typical errors").click();
  const exact = await until(page, (now) => now.ready);
  const { verdict, places, nuisances } = exact.answers.find((one) => one.method === "probabilistic");
  const expected = localized("probabilistic", exact, "--undeclared", "none");
  same("verdict of an exact robot", verdict, expected.status);
  samePlaces(places, expected);
  sameNuisances(nuisances, expected);
  same("the link carries it", page.url().includes("undeclared=none"), true);
  await page.getByText("Typical errors").click();
  await until(page, (now) => now.ready);
  write("good.svg", found.map);
  write("good.csv", found.log);
  const bad = [
    ["broken.svg", found.map.slice(0, found.map.length / 2), "--map"], ["open.geojson", '{"type":"FeatureCollection","features":[]}', "--map"],
    ["picture.pgm", "P5 2 2 255\n....", "--map"], ["short.csv", "t,x,y,theta,moment\n0,0,0,0,0\n1,2\n2,0,0,0,0\n", "log"],
    ["letters.csv", "t,x,y,theta,moment\n0,0,0,zero,0\n", "log"], ["word.toml", "[[whisker]]\nlenth = 0.07\n", "--robot"],
    ["long.toml", '[[whisker]]\nlength = "75 apples"\n', "--robot"],
    ["cut.mcap", "\u0089MCAP0\r\n", "log"], ["words.mcap", "nothing of the kind", "log"],
  ];
  for (const [name, text, what] of bad) {
    write(name, text);
    const args = ["localize", what === "log" ? name : "good.csv", "--map", what === "--map" ? name : "good.svg"];
    const { status, words } = command.complaint(...args, ...(what === "--robot" ? ["--robot", name] : []));
    same(`exit code for ${name}`, status, 1);
    await page.locator("#files").setInputFiles(join(command.folder, name));
    const { refused } = await until(page, (now) => now.refused.includes(name), 10000).catch(() => answers(page));
    same(`words about ${name}`, refused, words);
  }
  await page.locator("#files").setInputFiles([join(command.folder, "good.svg"), join(command.folder, "good.csv")]);
  await until(page, (now) => now.ready && now.file === "good.svg");
});

/** Contacts of page and command that are the same (m): two iterations, each to its own tolerance. */
const SAME_CONTACT = 1e-6;

/** The whisker as the page bends it, against a robot that `simulate` drives the same way to the same pose; whether it touches. */
function sameWhisker({ row, pose, whiskers }, log) {
  const [head, ...lines] = log.trim().split("\n").map((line) => line.split(","));
  const [x, y, theta] = ["x", "y", "theta"].map((name) => head.indexOf(name));
  const turned = ([u, v], a) => [u * Math.cos(a) - v * Math.sin(a), u * Math.sin(a) + v * Math.cos(a)];
  const odom = (line) => [Number(line[x]), Number(line[y]), Number(line[theta])];
  const [now, spin] = [odom(lines[row]), pose[2] - odom(lines[row])[2]];
  const way = lines.slice(0, row + 1).map((line) => {
    const then = odom(line);
    const [u, v] = turned([then[0] - now[0], then[1] - now[1]], spin);
    return [pose[0] + u, pose[1] + v, then[2] + spin];
  });
  const path = way.map((at) => `[${at.join(", ")}]`).join(", ");
  // The last row is to be at the end of the way.
  const took = way.slice(1).map((to, i) => Math.max(Math.hypot(to[0] - way[i][0], to[1] - way[i][1]) / 0.15, Math.abs(to[2] - way[i][2])));
  const time = took.reduce((sum, one) => sum + one, 0);
  const rate = (Math.ceil(300 * time) + 1e-7) / time;
  write("bent.toml", `map = "room.svg"\nrobot = "paper.toml"\n[noise]\nmoment_relative = 0\nmoment_absolute = 0\n[path]\nspeed = 0.15\nturn_rate = 1\nrate = ${rate}\nwaypoints = [${path}]\n`);
  // An estimate is off by a millimetre or so: where its way begins in a wall nothing can be compared.
  const { status, words } = command.complaint("simulate", "bent.toml", "--out", "bent");
  if (words.includes("does not start in free space")) return false;
  same("whether the way is simulated", status, 0);
  const table = (name) => readFileSync(join(command.folder, "bent", name), "utf8").trim().split("\n").map((line) => line.split(","));
  const [names, last] = [table("log.csv")[0], table("log.csv").at(-1)];
  const touch = table("contacts.csv").find((line) => line[0] === last[0]);
  same("whiskers", whiskers.length, 1);
  const [{ from, contact, moment, shape }] = whiskers;
  same("whether the map bends the whisker", from === "map", touch !== undefined);
  if (!touch) return false;
  const near = (what, found, expected, most) => {
    if (!(Math.abs(found - expected) <= most)) throw new Error(`${what}: the page says ${found}, the command ${expected}`);
  };
  [0, 1].forEach((axis) => near("where the whisker touches", contact[axis], Number(touch[1 + axis]), SAME_CONTACT));
  if (touch[4] === "tip") [0, 1].forEach((axis) => near("the tip", shape.at(-1)[axis], Number(touch[1 + axis]), SAME_CONTACT));
  near("the moment of the whisker", moment, Number(last[names.findIndex((name) => name.endsWith("moment"))]), 1e-7);
  return true;
}

await step("your own: the whisker as it bends at a row, against `simulate`", async () => {
  await scene(page, base, "own");
  const found = await until(page, (now) => now.ready);
  write("room.svg", found.map);
  write("paper.toml", found.robot);
  const time = page.locator(".timeline input");
  const touching = [];
  for (const value of [1000, 930, 820, 700, 580, 460]) {
    await time.evaluate((slider, at) => {
      slider.value = at;
      slider.dispatchEvent(new Event("input", { bubbles: true }));
    }, value);
    const { bent, shown } = await until(page, (now) => now.shown.time === value);
    same("whether a whisker is drawn", bent !== undefined, shown.places > 0);
    if (bent) touching.push(sameWhisker(bent, found.log));
  }
  if (touching.filter(Boolean).length < 3) throw new Error(`the whisker touches at ${touching} only`);
});

await step("your own: a recording with its map and robot, against `localize` on them", async () => {
  const scenarios = new URL("../../scenarios/", import.meta.url).pathname;
  command.json("simulate", join(scenarios, "corridor.toml"), "--mcap", "--out", ".");
  const map = join(scenarios, "maps/corridor.svg");
  await scene(page, base, "own");
  await until(page, (now) => now.ready);
  await page.locator("#files").setInputFiles([join(command.folder, "log.mcap"), join(command.folder, "robot.toml"), map]);
  const { answers: all, refused } = await until(page, (now) => now.ready && now.logFile === "log.mcap");
  same("refused", refused, "");
  for (const { method, verdict, places } of all) {
    const expected = command.json("localize", "log.mcap", "--map", map, "--robot", "robot.toml", "--method", method);
    same("verdict", verdict, expected.status);
    samePlaces(expected.status === "inconsistent" ? [] : places, expected);
  }
});

await step("live: the lines of `live --demo --json` come through the socket", async () => {
  const port = 20000 + Math.floor(20000 * Math.random());
  const run = spawn(resolve(program), ["live", "--demo", "--json", "--no-record", "--view", `${port}`], { stdio: ["ignore", "pipe", "ignore"] });
  try {
    let printed = "";
    run.stdout.on("data", (data) => (printed += data));
    await scene(page, base, `live?port=${port}`);
    const { lines, last } = await until(page, (now) => now.told >= 5 && now.lines > 0 && now.last.places.length > 0);
    await page.waitForTimeout(300);
    const line = printed.split("\n").filter(Boolean).map((one) => JSON.parse(one)).find((one) => one.t === last.t);
    same("line", JSON.stringify(last), JSON.stringify(line));
    same("boundaries", lines > 10, true);
    if (shots) {
      mkdirSync(shots, { recursive: true });
      await page.screenshot({ path: join(shots, "live-run-1280-light.png"), fullPage: true });
    }
  } finally {
    run.kill("SIGINT");
  }
});

await step("live: whiskers, readings and losses as docs/live.md has them, and the way back", async () => {
  await feed(page, 8123);
  await scene(page, base, "live?port=8123");
  const now = await until(page, (one) => one.told === STEPS.length, 20000);
  same("charts", now.charts.join(" "), "left.moment right.moment");
  same("gaps", now.gaps[0], 1);
  const off = (told, at) => STEPS[at].tips.findIndex((expected, k) => expected.some((v, axis) => !(Math.abs(told.tips[k]?.[axis] - v) <= 1e-4)));
  // What has been told is drawn with the next frame.
  const tip = async (at) => {
    await until(page, (one) => off(one, at) < 0, 5000).catch(() => {});
    const told = await answers(page);
    const k = off(told, at);
    if (k >= 0) throw new Error(`whisker ${k} ends at ${told.tips[k]}, not at ${STEPS[at].tips[k]}`);
  };
  await tip(STEPS.length - 1);
  const lost = (count) => page.getByText(`${count} (2 lost, 1 unjoined)`).waitFor({ timeout: 3000 });
  await lost(3);
  if (shots) {
    mkdirSync(shots, { recursive: true });
    await page.screenshot({ path: join(shots, "live-whiskers-1280-light.png"), fullPage: true });
    await page.emulateMedia({ colorScheme: "dark" });
    await page.setViewportSize({ width: 390, height: 844 });
    await page.waitForTimeout(400);
    await page.screenshot({ path: join(shots, "live-whiskers-390-dark.png"), fullPage: true });
    await page.emulateMedia({ colorScheme: "light" });
    await page.setViewportSize({ width: 1280, height: 800 });
  }
  await page.getByRole("button", { name: "Step back" }).focus();
  for (let k = 0; k < 4; k++) await page.keyboard.press("Enter");
  const then = await answers(page);
  same("time", then.shown, STEPS.at(-5).t);
  await tip(STEPS.length - 5);
  if (shots) await page.screenshot({ path: join(shots, "live-back-1280-light.png"), fullPage: true });
});

await step("keyboard, names for screen readers, narrow screens", async () => {
  await scene(page, base, "bend");
  await page.locator(".handle.push").first().focus();
  const before = (await answers(page)).given;
  await page.keyboard.press("ArrowUp");
  const after = (await answers(page)).given;
  same("one key, one millimetre", Math.round(1e6 * (after.y - before.y)), 1000);
  const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
  for (const scheme of ["light", "dark"]) {
    await page.emulateMedia({ colorScheme: scheme });
    for (const name of SCENES) {
      await scene(page, base, name);
      await page.evaluate(axe);
      const { violations } = await page.evaluate(() => window.axe.run());
      const words = violations.map((v) => `${v.id}: ${v.nodes.map((n) => n.target.join(" ")).join("; ")}`);
      if (words.length) throw new Error(`${name}, ${scheme}: ${words.join("\n")}`);
    }
  }
  await page.setViewportSize({ width: 390, height: 844 });
  for (const name of SCENES) {
    await scene(page, base, name);
    const width = await page.evaluate(() => document.scrollingElement.scrollWidth);
    if (width > 390) throw new Error(`${name} is ${width} pixels wide on a screen of 390`);
  }
  await page.setViewportSize({ width: 1280, height: 800 });
});

const timed = rest.includes("--times") ? step : async () => undefined;
await timed("how long things take (told, not tested)", async () => {
  const middle = (values) => [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)];
  await scene(page, base, "bend");
  const first = await page.evaluate(() => performance.getEntriesByName("first-frame")[0].startTime);
  console.log(`          first frame after ${first.toFixed(0)} ms`);
  for (const name of ["bend", "contact"]) {
    await scene(page, base, name);
    const times = await page.evaluate(() => {
      const handle = document.querySelector(".handle.push");
      const { x, y, width, height } = handle.getBoundingClientRect();
      const at = (k) => ({ clientX: x + width / 2 + 30 * Math.sin(k / 9), clientY: y + height / 2 - 25 * Math.sin(k / 7), pointerId: 1, bubbles: true });
      handle.setPointerCapture = () => undefined;
      handle.dispatchEvent(new PointerEvent("pointerdown", at(0)));
      const spent = [];
      for (let k = 1; k <= 150; k++) {
        const began = performance.now();
        handle.dispatchEvent(new PointerEvent("pointermove", at(k)));
        handle.getBoundingClientRect();
        spent.push(performance.now() - began);
      }
      handle.dispatchEvent(new PointerEvent("pointerup", at(0)));
      return spent;
    });
    console.log(`          ${name}: drag to drawn ${middle(times).toFixed(2)} ms (median), ${Math.max(...times).toFixed(1)} ms at most`);
  }
  (await frames(page, base)).forEach((line) => console.log(`          ${line}`));
});

if (shots) {
  mkdirSync(shots, { recursive: true });
  await step(`pictures into ${shots}`, async () => {
    for (const scheme of ["light", "dark"]) {
      await page.emulateMedia({ colorScheme: scheme });
      for (const [width, height] of [[1280, 800], [390, 844]]) {
        await page.setViewportSize({ width, height });
        for (const name of SCENES) {
          await scene(page, base, name);
          await page.waitForTimeout(name === "shrink" ? 2200 : name === "own" || name === "preimage" ? 3500 : 400);
          await page.screenshot({ path: join(shots, `${name}-${width}-${scheme}.png`), fullPage: true });
        }
      }
    }
  });
}

await context.close();
// Until a live run starts, the page asks for it again and again, which the browser notes.
const real = faults.filter((fault) => !fault.includes("WebSocket"));
if (real.length) throw new Error(`the page complained: ${real.join("; ")}`);
const { checked, worst } = compared();
console.log(`studio: ${checked} comparisons of page and command, the largest difference ${worst.toExponential(1)}`);
