//! A localization as a film: the states that explain the log so far, moment by moment, on one page of HTML.

use super::axes::{scale_bar, ticks};
use super::canvas::Canvas;
use super::document::{Document, escape, number};
use super::legend::{Entry, LINE, Sample, legend};
use super::localization::{LocalizationScene, map_canvas};
use super::outlines::{draw_outlines, outline_entries};
use crate::flow::one_in;
use crate::flow::trajectory::pose_at;
use crate::plane::{Pose2, Vec2};
use std::fmt::Write;

/// The states that explain the log up to a time.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmFrame {
    /// When (s).
    pub t: f64,
    /// The states, map frame.
    pub states: Vec<Pose2>,
}

const TOP: f64 = 60.0;
const MARGIN: f64 = 20.0;
const BELOW: f64 = 52.0;
const WIDTH: f64 = 580.0;
/// Length of a state's tick (px).
const TICK: f64 = 6.0;
/// About this many states of a frame are drawn at most; of more, one in so many.
const DRAWN: usize = 1200;

/// The film as one HTML file that needs no other; the same scene and frames give the same bytes.
#[must_use]
pub fn localization_film(scene: &LocalizationScene<'_>, frames: &[FilmFrame]) -> String {
    let mut canvas = map_canvas(scene, TOP);
    draw_outlines(&mut canvas, scene.map);
    let data: Vec<String> = frames.iter().map(|frame| shown(&canvas, scene, frame)).collect();
    let entries = entries(scene, frames);
    let (left, right) = entries.split_at(entries.len().div_ceil(2));
    let below = TOP + canvas.frame().height + BELOW;
    let height = below + LINE * left.len() as f64 + MARGIN;
    let mut document = Document::new(WIDTH, height, scene.title, "The states that explain the log, as it goes on.");
    document.text(MARGIN, 30.0, "heading", scene.title);
    ticks(&mut document, &canvas, "map frame");
    scale_bar(&mut document, &canvas, 30.0);
    let truth: Vec<Vec2> = scene.truth.into_iter().flatten().map(|row| row.map_from_robot.position()).collect();
    canvas.trail(&truth, "truth");
    canvas.raw(LAYERS);
    canvas.place(&mut document);
    legend(&mut document, MARGIN, below, left);
    legend(&mut document, 0.5 * WIDTH, below, right);
    PAGE.replace("TITLE", &escape(scene.title))
        .replace("FIGURE", &document.finish())
        .replace("FRAMES", &format!("[{}]", data.join(",\n")))
}

/// What the film shows, in the words and colours of the figure.
fn entries(scene: &LocalizationScene<'_>, frames: &[FilmFrame]) -> Vec<Entry> {
    let samples = [
        (
            frames.iter().any(|frame| !frame.states.is_empty()),
            Sample::Dots("survivor", "survivor-tick"),
            "states that explain the log so far",
        ),
        (!scene.answer.trajectory.is_empty(), Sample::Line("estimate-line"), "the robot, by the whole log"),
        (!scene.answer.shapes.is_empty(), Sample::Line("whisker-last"), "whiskers, by the whole log"),
        (scene.truth.is_some(), Sample::Line("truth"), "true path"),
        (scene.truth.is_some(), Sample::Circle("truth-mark"), "true pose"),
    ];
    let there = samples.into_iter().filter(|(there, ..)| *there);
    let mut entries: Vec<Entry> = there.map(|(_, sample, words)| Entry { sample, words: words.into() }).collect();
    entries.extend(outline_entries(scene.map));
    entries
}

/// A frame as a list for the page: time, count of states, and the paths of ticks, dots, whiskers, estimate and true pose.
fn shown(canvas: &Canvas, scene: &LocalizationScene<'_>, frame: &FilmFrame) -> String {
    let (mut ticks, mut dots, mut whiskers, mut robot) = (String::new(), String::new(), String::new(), String::new());
    let stride = frame.states.len().div_ceil(DRAWN).max(1);
    for state in one_in(&frame.states, stride).filter(|state| canvas.shows(state.position())) {
        let (p, tick) = (canvas.page(state.position()), Vec2::from_angle(state.theta) * TICK);
        // Writing into a string cannot fail.
        let _ = write!(dots, "M{} {}h0", number(p.x), number(p.y));
        let _ = write!(ticks, "M{} {}l{} {}", number(p.x), number(p.y), number(tick.x), number(-tick.y));
    }
    let answer = scene.answer;
    if let Some(pose) = pose_at(&answer.trajectory, frame.t) {
        let (p, tick) = (canvas.page(pose.position()), Vec2::from_angle(pose.theta) * (3.0 * TICK));
        let _ = write!(robot, "M{} {}l{} {}", number(p.x), number(p.y), number(tick.x), number(-tick.y));
        let whisker_count = answer.shapes.iter().map(|shape| shape.whisker + 1).max().unwrap_or(0);
        for whisker in 0..whisker_count {
            let distance = |t: f64| (t - frame.t).abs();
            let of = answer.shapes.iter().filter(|shape| shape.whisker == whisker);
            let Some(shape) = of.min_by(|a, b| distance(a.t).total_cmp(&distance(b.t))) else { continue };
            if distance(shape.t) > NEAR {
                continue;
            }
            for (index, &point) in shape.points.iter().enumerate() {
                let p = canvas.page(pose.transform_point(point));
                let _ = write!(whiskers, "{}{} {}", if index == 0 { 'M' } else { 'L' }, number(p.x), number(p.y));
            }
        }
    }
    let truth = scene.truth.and_then(|truth| pose_at(truth, frame.t)).map_or_else(String::new, |pose| {
        let (p, tick) = (canvas.page(pose.position()), Vec2::from_angle(pose.theta) * (3.0 * TICK));
        let [x, y, dx, dy] = [p.x, p.y, tick.x, -tick.y].map(number);
        // A circle of two arcs, and the heading from its middle.
        format!(
            "M{x} {y}m-{RING} 0a{RING} {RING} 0 1 0 {D} 0a{RING} {RING} 0 1 0 -{D} 0M{x} {y}l{dx} {dy}",
            D = 2 * RING
        )
    });
    let count = frame.states.len();
    format!("[{:.3},{count},\"{ticks}\",\"{dots}\",\"{whiskers}\",\"{robot}\",\"{truth}\"]", frame.t)
}

/// A whisker's shape is shown for frames no further away than this (s).
const NEAR: f64 = 0.1;

/// Radius of the ring around the true pose (px).
const RING: u32 = 9;

const LAYERS: &str = "<path id=\"ticks\" class=\"survivor-tick\"/>\n<path id=\"dots\" class=\"survivor\"/>\n\
                      <path id=\"whiskers\" class=\"whisker-last\"/>\n<path id=\"robot\" class=\"estimate-line\"/>\n\
                      <path id=\"truth\" class=\"truth-mark\"/>\n";

const PAGE: &str = r#"<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>TITLE</title>
<style>
body { font: 15px system-ui, sans-serif; max-width: 900px; margin: 16px auto; padding: 0 12px; color: #1a1a1a; }
svg { width: 100%; height: auto; }
.controls { display: flex; gap: 12px; align-items: center; }
input { flex: 1; }
</style></head><body>
<div class="controls"><button id="play">Pause</button><input id="at" type="range" min="0" value="0" aria-label="time"><span id="words"></span></div>
FIGURE
<script>
const frames = FRAMES;
const at = document.getElementById('at'), play = document.getElementById('play');
at.max = frames.length - 1;
let running = true;
function show(k) {
  const [t, count, ticks, dots, whiskers, robot, truth] = frames[k];
  for (const [id, d] of Object.entries({ ticks, dots, whiskers, robot, truth })) document.getElementById(id).setAttribute('d', d || 'M0 0');
  document.getElementById('words').textContent = t.toFixed(2) + ' s, ' + (count === 0 ? 'no states: too little was felt so far, or nothing explains it' : count + (count === 1 ? ' state' : ' states'));
  at.value = k;
}
at.oninput = () => { running = false; play.textContent = 'Play'; show(+at.value); };
play.onclick = () => { running = !running; play.textContent = running ? 'Pause' : 'Play'; };
setInterval(() => { if (running && frames.length) show((+at.value + 1) % frames.length); }, 80);
if (frames.length) show(0);
</script></body></html>
"#;
