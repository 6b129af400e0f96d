//! What the figure shows, layer by layer from the ground up.

use super::{LocalizationScene, counted, entry};
use crate::canvas::{Canvas, WorldBounds};
use crate::flow::one_in;
use crate::flow::pose::{Hypothesis, Localization, StampedPose, Status};
use crate::flow::trajectory::pose_at;
use crate::legend::{Entry, Sample};
use crate::outlines::outline_entries;
use crate::places::{NUMBERED, places};
use crate::plane::{Pose2, Vec2};
use crate::sets::StateBox;

/// At most this many whisker shapes are drawn, of all whiskers together.
const SHAPES: usize = 25;
/// About this many candidates are drawn at most, and as many survivors; of more, one in so many.
const CANDIDATES: usize = 4000;

/// Draws the candidates after the first observation, each moved along to the last row.
pub(super) fn candidates(canvas: &mut Canvas, answer: &Localization, tick: f64) {
    let shown = || one_in(answer.first_states.iter().copied(), stride(answer.first_states.len()));
    canvas.heading_ticks(shown(), tick, "candidate-tick");
    canvas.dots(shown().map(Pose2::position), "candidate");
}

/// Draws the true path and the true pose at the end.
pub(super) fn truth(canvas: &mut Canvas, scene: &LocalizationScene<'_>, tick: f64) {
    let Some(truth) = scene.truth else { return };
    canvas.trail(&positions(truth), "truth");
    if let Some(end) = scene.true_end().or_else(|| truth.last().map(|row| row.map_from_robot)) {
        canvas.heading_ticks([end], tick, "truth-mark");
        canvas.circle(end.position(), 9.5, "truth-mark");
    }
}

/// Draws the whiskers along the sweep, the last shape of each strongest.
pub(super) fn whiskers(canvas: &mut Canvas, answer: &Localization) {
    let each = of_each_whisker(answer);
    let drawn = each.iter().filter(|shapes| !shapes.is_empty()).count().max(1);
    let most = (SHAPES / drawn).max(1);
    for shapes in &each {
        let Some((_, earlier)) = shapes.split_last() else { continue };
        for shape in earlier.iter().step_by(shapes.len().div_ceil(most)) {
            canvas.polyline(shape, "whisker");
        }
    }
    for last in each.iter().filter_map(|shapes| shapes.last()) {
        canvas.polyline(last, "whisker-last");
    }
}

/// The placed shapes whisker by whisker.
fn of_each_whisker(answer: &Localization) -> Vec<Vec<Vec<Vec2>>> {
    let mut each: Vec<Vec<Vec<Vec2>>> = Vec::new();
    for (whisker, points) in placed(answer) {
        if each.len() <= whisker {
            each.resize_with(whisker + 1, Vec::new);
        }
        each[whisker].push(points);
    }
    each
}

/// The whisker shapes in the map frame, for those times at which the robot's place is estimated.
pub(super) fn placed_shapes(answer: &Localization) -> impl Iterator<Item = Vec<Vec2>> {
    placed(answer).map(|(_, points)| points)
}

/// The same with the index of the whisker.
fn placed(answer: &Localization) -> impl Iterator<Item = (usize, Vec<Vec2>)> {
    answer.shapes.iter().filter_map(|shape| {
        let pose = pose_at(&answer.trajectory, shape.t)?;
        Some((shape.whisker, shape.points.iter().map(|&point| pose.transform_point(point)).collect()))
    })
}

/// Draws the estimated path from its start.
pub(super) fn path(canvas: &mut Canvas, answer: &Localization) {
    for (rows, sure) in stretches(answer) {
        canvas.trail(&positions(rows), if sure { "path" } else { "path-unsure" });
    }
    if let Some(first) = answer.trajectory.first() {
        canvas.circle(first.map_from_robot.position(), 4.0, "start");
    }
}

/// The trajectory in pieces that are sure or not, by turns; each begins with the last row of the one before.
fn stretches(answer: &Localization) -> Vec<(&[StampedPose], bool)> {
    let rows = answer.trajectory.as_slice();
    // A step is as sure as the rows at its two ends.
    let doubted = |row: &StampedPose| answer.unsure.iter().any(|s| (s.from..=s.to).contains(&row.t));
    let steps: Vec<bool> = rows.windows(2).map(|pair| !(doubted(&pair[0]) || doubted(&pair[1]))).collect();
    let mut start = 0;
    let mut piece = |alike: &[bool]| {
        let from = start;
        start += alike.len();
        (&rows[from..=start], alike[0])
    };
    steps.chunk_by(|a, b| a == b).map(&mut piece).collect()
}

/// Draws what is left of the candidates: points as dots with headings, boxes as boxes.
pub(super) fn survivors(canvas: &mut Canvas, answer: &Localization, tick: f64) {
    let every = stride(answer.states.len());
    let shown = || one_in(&answer.states, every);
    for state in shown().filter(|state| !is_point(state)) {
        let (x, y) = (state.x, state.y);
        let [a, b] = [Vec2::new(x.lo(), y.lo()), Vec2::new(x.hi(), y.hi())];
        canvas.polygon(&[a, Vec2::new(b.x, a.y), b, Vec2::new(a.x, b.y)], "survivor-box");
    }
    let points = || shown().filter(|state| is_point(state)).map(middle);
    canvas.heading_ticks(points(), tick, "survivor-tick");
    canvas.dots(points().map(Pose2::position), "survivor");
}

/// Draws the frame of what another panel shows close up.
pub(super) fn zoomed(canvas: &mut Canvas, world: WorldBounds) {
    // Never smaller than the marker that it surrounds.
    let WorldBounds { min, max } = world.grown((14.0 / canvas.scale() - 0.5 * world.size().x).max(0.0));
    canvas.polygon(&[min, Vec2::new(max.x, min.y), max, Vec2::new(min.x, max.y)], "zoomed");
}

/// Draws the estimate, in the close-up with its extent; several places are numbered.
pub(super) fn estimate(canvas: &mut Canvas, scene: &LocalizationScene<'_>, close_up: bool) {
    let answer = scene.answer;
    if answer.status == Status::Inconsistent {
        return;
    }
    for hypothesis in answer.hypotheses.iter().take(NUMBERED) {
        extent(canvas, hypothesis, close_up);
    }
    for hypothesis in answer.hypotheses.iter().take(NUMBERED) {
        let ridge: Vec<Vec2> = hypothesis.ridge.iter().map(|pose| pose.position()).collect();
        canvas.trail(&ridge, "ridge");
    }
    let Some(pose) = answer.estimate else { return };
    if !close_up && scene.robot.len() > 2 {
        let outline: Vec<Vec2> = scene.robot.iter().map(|&point| pose.transform_point(point)).collect();
        canvas.polygon(&outline, "robot");
    }
    if answer.hypotheses.len() > 1 && !close_up {
        let poses: Vec<Pose2> = answer.hypotheses.iter().map(|hypothesis| hypothesis.pose).collect();
        let survivors = one_in(&answer.states, stride(answer.states.len())).map(|s| vec![middle(s).position()]);
        let shapes = of_each_whisker(answer).into_iter().filter_map(|mut shapes| shapes.pop());
        let drawn: Vec<Vec<Vec2>> = survivors.chain(shapes).chain([positions(&answer.trajectory)]).collect();
        places(canvas, &poses, &drawn);
        return;
    }
    canvas.arrow(pose, if close_up { 44.0 } else { 26.0 }, "estimate-line", "estimate");
    canvas.circle(pose.position(), 5.5, "estimate");
}

fn extent(canvas: &mut Canvas, hypothesis: &Hypothesis, close_up: bool) {
    let StateBox { x, y, theta } = hypothesis.extent;
    if x.is_empty() || y.is_empty() {
        return;
    }
    let [a, b] = [Vec2::new(x.lo(), y.lo()), Vec2::new(x.hi(), y.hi())];
    canvas.polygon(&[a, Vec2::new(b.x, a.y), b, Vec2::new(a.x, b.y)], "extent");
    if close_up && theta.width() > 0.0 && theta.width() < core::f64::consts::TAU {
        let radius = 62.0 / canvas.scale();
        let centre = hypothesis.pose.position();
        let arc = (0..=24).map(|step| theta.lo() + theta.width() * f64::from(step) / 24.0);
        let fan: Vec<Vec2> =
            core::iter::once(centre).chain(arc.map(|angle| centre + Vec2::from_angle(angle) * radius)).collect();
        canvas.polygon(&fan, "fan");
    }
}

/// The legend: one entry for each layer that is there.
pub(super) fn legend_entries(scene: &LocalizationScene<'_>, canvas: &Canvas) -> Vec<Entry> {
    let answer = scene.answer;
    let mut entries = Vec::new();
    let mut add = |there: bool, sample: Sample, words: String| {
        if there {
            entries.push(entry(sample, words));
        }
    };
    let (all, left) = (answer.first_states.len(), answer.states.len());
    let every = |count: usize| match stride(count) {
        1 => String::new(),
        stride => format!(" (1 in {stride})"),
    };
    let answered = answer.status != Status::Inconsistent;
    let several = answered && answer.hypotheses.len() > 1;
    add(
        all > 0,
        Sample::Dots("candidate", "candidate-tick"),
        format!("{} at the first touch{}", counted(all, super::words::part(answer)), every(all)),
    );
    let sets = answer.states.iter().any(|state| !is_point(state));
    let survivor = if sets { Sample::Patch("survivor-box") } else { Sample::Dots("survivor", "survivor-tick") };
    let kept =
        if answer.encloses { "boxes around what is left of the cells" } else { "left at the end, likely or not" };
    add(left > 0, survivor, format!("{left} {kept}{}", every(left)));
    add(
        answered && answer.estimate.is_some() && !several,
        Sample::Heading("estimate", "estimate-line"),
        "estimate and heading".into(),
    );
    add(several, Sample::Heading("badge", "estimate-line"), "a place that explains the log".into());
    add(
        answered && !answer.hypotheses.is_empty(),
        Sample::Patch("extent"),
        if several { "extent of a place" } else { "extent of the place" }.into(),
    );
    add(
        answered && answer.hypotheses.iter().any(|hypothesis| !hypothesis.ridge.is_empty()),
        Sample::Line("ridge"),
        "where along a place the robot may be".into(),
    );
    add(!answer.trajectory.is_empty(), Sample::Line("path"), "estimated path, from the circle".into());
    let doubted = stretches(answer).iter().any(|(_, sure)| !sure);
    add(doubted, Sample::Line("path-unsure"), "where the path is not sure".into());
    add(scene.truth.is_some(), Sample::Line("truth"), "true path".into());
    add(scene.truth.is_some(), Sample::Circle("truth-mark"), "true pose at the end".into());
    let whiskers = placed_shapes(answer).flatten().any(|point| canvas.shows(point));
    let many = answer.shapes.iter().any(|shape| shape.whisker != answer.shapes[0].whisker);
    let words = if many { "whiskers along the sweep" } else { "whisker along the sweep" };
    add(whiskers, Sample::Line("whisker-last"), words.into());
    entries.extend(outline_entries(scene.map));
    entries
}

/// One in how many of `count` states is drawn.
fn stride(count: usize) -> usize {
    count.div_ceil(CANDIDATES).max(1)
}

fn positions(path: &[StampedPose]) -> Vec<Vec2> {
    path.iter().map(|row| row.map_from_robot.position()).collect()
}

fn is_point(state: &StateBox) -> bool {
    state.x.width() <= 0.0 && state.y.width() <= 0.0
}

fn middle(state: &StateBox) -> Pose2 {
    let half = |interval: crate::sets::Interval| 0.5 * (interval.lo() + interval.hi());
    Pose2::new(half(state.x), half(state.y), half(state.theta))
}
