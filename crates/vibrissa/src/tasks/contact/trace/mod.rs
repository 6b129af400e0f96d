//! Where the contact went while it slid along a wall: the whole stretch of contact at once.
//!
//! Without friction the force on a whisker is normal to what it touches, and the contact moves across that force at every
//! instant: a tip along the wall, a side along the whisker that lies on it, and a side on a corner not at all. A tip has its arc
//! length given and the force's tilt open, a side the other way round; and a tip comes to lie on its side where the tilt goes
//! through nought, since a whisker that heads out of the wall would have to come from inside it. So one number tells both: the
//! *lean*, the tilt towards the wall where it is positive, and the share of the whisker beyond the contact where it is
//! negative. A stretch of contact is one least-squares problem. Its unknowns are force and lean at each node; what it
//! asks for:
//!
//! | residual | in units of |
//! | --- | --- |
//! | the moment is the reading | the reading's standard deviation |
//! | a step of the contact is across the mean force of its ends | [`TraceOptions::step_std`], more where the wall turns in between |
//! | the wall turns little, and seldom much (Cauchy's loss) | [`TraceOptions::turn`] times the root of the travel |
//! | the lean is moderate | [`TILT_STD`], and a share of the whisker |
//! | a side lies on what curves away from it | how much walls turn, and the travel of the base |
//! | a side slides along the whisker no faster than the base moves | the travel of the base |
//!
//! Neighbours alone are coupled, so the normal equations are a band, and a sweep is solved in milliseconds.
//!
//! | file | what it knows |
//! | --- | --- |
//! | `node` | one reading's contact for given unknowns, with derivatives |
//! | `problem` | the residuals of a stretch, and what they leave open |
//! | `search` | starts, and how they grow |
//! | `corners` | turns of the wall that the readings leave open |

mod corners;
mod node;
mod problem;
mod search;

use crate::Stop;
use crate::beam::{Bend, Whisker};
use crate::plane::{Pose2, Vec2};
use problem::{TraceProblem, Way};

/// Standard deviation of the force's tilt from the whisker's normal (rad): wide, it only speaks where nothing else does.
const TILT_STD: f64 = 0.8;
/// Standard deviation of the share of the whisker beyond a side that slides: tips are what touches most.
const SIDE_STD: f64 = 0.2;
/// The same where the tip alone is to explain the readings.
const TIP_ALONE: f64 = 3e-3;
/// Lean from which on a way is one with the tip alone.
const TIP_NEAR: f64 = 0.01;
/// What a way with the side has to save beside one with the tip alone (half a sum of squares): a chance of 1 in 150.
const SIDE_GAIN: f64 = 5.0;
/// Fewest nodes of a trace.
const FEWEST: usize = 5;
/// A fall of the moment from one node to the next is a snap when it is beyond what the errors and this many times the
/// stiffness of a hardly bent whisker explain; onsets reach 3, but they rise.
const SNAP: f64 = 3.0;
/// Share of a curled trace's length below which one that is less bent is taken to be wrong.
const CURLED: f64 = 0.7;
/// Largest slope at the contact on the branch that grows from the straight whisker (rad): near the fold, and beyond it the
/// moment alone would lead on to the curled shapes, to which a whisker comes by a snap only.
const LARGEST_SLOPE: f64 = 1.7;

/// One node: a reading, or the mean of neighbouring ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TraceNode {
    /// When (s).
    pub t: f64,
    /// The whisker's base, odometry frame.
    pub odom_from_whisker: Pose2,
    /// The moment (N m), not zero; all nodes of a trace have the same sign.
    pub moment: f64,
    /// Its standard deviation (N m).
    pub std: f64,
}

/// What is known of walls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TraceOptions {
    /// How far a step of the contact may miss the wall's direction (m).
    pub step_std: f64,
    /// How much the wall turns along the way (rad per root of a metre).
    pub turn: f64,
    /// Whether a whisker may be curled where the less bent branch ends early.
    pub curled: bool,
}

/// A contact along a trace, odometry frame.
#[derive(Clone, Debug, PartialEq)]
pub struct TracePoint {
    /// When (s).
    pub t: f64,
    /// The contact (m).
    pub position: Vec2,
    /// Direction of the wall's normal, which is that of the force (rad).
    pub normal: f64,
    /// Standard deviation of the place across the wall (m), with what other ways that explain the readings differ by.
    pub std: f64,
    /// The whisker; its arc length is the whisker's for a tip, and less for a side.
    pub bend: Bend,
    /// The moment's residual, in standard deviations.
    pub residual: f64,
}

/// One uninterrupted way of the contact.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// The contacts, one for each node, in order of time.
    pub points: Vec<TracePoint>,
    /// How far other ways that explain the readings nearly as well are from this one (m): root of the mean square over the nodes.
    pub doubt: f64,
}

/// The contact's ways through `nodes`, with tip or side: one trace, or several where the contact jumps in between.
///
/// No step of a trace misses the direction of the wall: where one would, the trace ends. Nodes that fit no trace are left out;
/// empty when there is none at all.
#[must_use]
pub fn contact_traces(whisker: &Whisker, nodes: &[TraceNode], options: TraceOptions) -> Vec<Trace> {
    traces_until(whisker, nodes, options, &Stop::default())
}

/// As [`contact_traces`]; what is found once the end is asked for is no answer.
pub(super) fn traces_until(whisker: &Whisker, nodes: &[TraceNode], options: TraceOptions, stop: &Stop) -> Vec<Trace> {
    let mut traces = Vec::new();
    let mut from = 0;
    while from < nodes.len() && !stop.is_asked() {
        let snap = (from + 1..nodes.len()).find(|&i| snaps(whisker, &nodes[i - 1], &nodes[i]));
        let to = snap.unwrap_or(nodes.len());
        without_snap(whisker, &nodes[from..to], options, stop, &mut traces);
        from = to;
    }
    traces
}

/// Whether the moment falls by more than errors and the motion of the base explain.
fn snaps(whisker: &Whisker, a: &TraceNode, b: &TraceNode) -> bool {
    let step = a.odom_from_whisker.between(b.odom_from_whisker);
    let travel = step.position().norm() + whisker.length * step.theta.abs();
    let stiffness = 3.0 * whisker.flexural_rigidity / (whisker.length * whisker.length);
    a.moment.abs() - b.moment.abs() > 2.0 * (a.std + b.std) + SNAP * stiffness * travel
}

/// The traces through nodes of one sign, added to those before.
fn without_snap(whisker: &Whisker, nodes: &[TraceNode], options: TraceOptions, stop: &Stop, traces: &mut Vec<Trace>) {
    let mut rest = nodes;
    while rest.len() >= FEWEST && !stop.is_asked() {
        let problem = TraceProblem::new(whisker, rest, options, LARGEST_SLOPE, stop);
        let least = tip_or_side(&problem);
        // The less bent branch, unless it ends much earlier: that the whisker is curled has to be shown.
        let nodes_of = |ways: &Vec<Way>| ways.first().map_or(0, |way| way.state.len());
        let may_be_curled =
            options.curled && !traces.is_empty() && CURLED * (rest.len() as f64) > nodes_of(&least) as f64;
        let curled = TraceProblem { largest_slope: f64::INFINITY, ..problem };
        let curled = if may_be_curled { curled.best(1) } else { Vec::new() };
        let short = CURLED * (nodes_of(&curled) as f64) > nodes_of(&least) as f64;
        let (mut ways, largest_slope) = if short { (curled, f64::INFINITY) } else { (least, LARGEST_SLOPE) };
        let mut rivals = ways.split_off(ways.len().min(1));
        let best = ways.pop().map(|way| TraceProblem { largest_slope, side_std: SIDE_STD, ..problem }.until_torn(way));
        let used = best.as_ref().map_or(0, |way| way.state.len());
        let best = best.filter(|_| used >= FEWEST).map(|way| {
            let side_std =
                if way.unknowns.iter().skip(1).step_by(2).all(|lean| *lean > -TIP_NEAR) { TIP_ALONE } else { SIDE_STD };
            let (best, others) = TraceProblem { largest_slope, side_std, ..problem.part(0, used) }.around(way);
            rivals.extend(others);
            best
        });
        let part = TraceProblem { largest_slope: f64::INFINITY, side_std: SIDE_STD, ..problem.part(0, used) };
        let whole = best.filter(|way| used >= FEWEST && part.torn(&way.state).is_none());
        traces.extend(whole.and_then(|way| part.trace(&way, &rivals)));
        // Where no trace is, the next one is not looked for at every node unless it may be any.
        rest = &rest[used.max(if options.curled { 1 } else { FEWEST.min(rest.len()) })..];
    }
}

/// The ways on the less bent branch: with the tip alone unless a side explains much more of the readings, or them much better. The
/// other ways are kept as rivals.
fn tip_or_side(problem: &TraceProblem) -> Vec<Way> {
    let mut tips = problem.best(0);
    let whole = tips.first().is_some_and(|tip| tip.state.len() == problem.nodes.len());
    let sides = TraceProblem { side_std: SIDE_STD, ..*problem }.best_beside(0, if whole { &tips } else { &[] });
    let (Some(tip), Some(side)) = (tips.first(), sides.first()) else {
        return if tips.is_empty() { sides } else { tips };
    };
    let (short, long) = (tip.state.len(), side.state.len());
    let shorter = CURLED * long as f64 > short as f64;
    let worse = long >= short
        && problem.cost_of(tip, short)
            > SIDE_GAIN + TraceProblem { side_std: SIDE_STD, ..*problem }.cost_of(side, short);
    if shorter || worse {
        return sides;
    }
    tips.extend(sides.into_iter().filter(|way| way.state.len() >= short));
    tips
}
