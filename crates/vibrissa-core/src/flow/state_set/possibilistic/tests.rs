//! Random contacts from the closed form: the state in which they happen is never ruled out.

mod rods;

use super::super::tests::random::Random;
use super::contractor::{self, BaseView, BoundaryLevels};
use super::errors::{PoseSlack, UncertainWhisker};
use super::initial_cover;
use super::parallelotope::Parallelotope;
use super::record::ReadingContacts;
use super::sivia::StageProgress;
use super::thick_piece::{COARSE, FINE, PieceIndex, ThickPiece};
use super::two_contacts::TwoContacts;
use crate::beam::elastica;
use crate::beam::press::{ContactTable, PressTable};
use crate::config::PossibilisticOptions;
use crate::plane::{Curve, Pose2, Vec2, wrap_angle};
use crate::sets::Interval;
use crate::world::{Boundary, Map, MountedWhisker, Robot, Role};
use core::f64::consts::{FRAC_PI_2, PI};

/// A room with sharp corners both ways, an ellipse-like blob of many short lines, and an open wall.
fn map() -> Map {
    let room = [(0.0, 0.0), (0.5, 0.0), (0.5, 0.2), (0.42, 0.24), (0.5, 0.4), (0.2, 0.4), (0.2, 0.35), (0.0, 0.4)];
    let room: Vec<Vec2> = room.iter().map(|&(x, y)| Vec2::new(x, y)).collect();
    let blob: Vec<Vec2> = (0..300)
        .map(|k| {
            let a = f64::from(k) / 300.0 * 2.0 * PI;
            // Half of it is rough, so that it is cut finely.
            let rough = if k < 150 { 2e-4 * f64::from(k % 2) } else { 0.0 };
            Vec2::new(0.15 + (0.05 + rough) * a.cos(), 0.15 + (0.03 + rough + 0.004 * (5.0 * a).sin()) * a.sin())
        })
        .collect();
    let wall = [(0.3, 0.1), (0.4, 0.15), (0.35, 0.25)].map(|(x, y)| Vec2::new(x, y));
    let make = |role, curve: Option<Curve>| Boundary::new(role, curve.unwrap(), None).unwrap();
    Map::new(vec![
        make(Role::Arena, Curve::polyline(&room, true)),
        make(Role::Obstacle, Curve::polyline(&blob, true)),
        make(Role::Obstacle, Curve::circle(Vec2::new(0.3, 0.32), 0.03)),
        make(Role::Wall, Curve::polyline(&wall, false)),
    ])
    .unwrap()
}

/// A boundary point with a normal that friction and corners allow, from the map's own curves, and whether it holds a tip.
fn foothold(map: &Map, draw: &mut Random, corners: bool) -> (Vec2, f64, bool) {
    let boundary = &map.boundaries()[(draw.unit() * map.boundaries().len() as f64) as usize];
    let flip = if boundary.is_two_sided() && draw.unit() < 0.5 { PI } else { 0.0 };
    let curve = boundary.curve();
    let segments = curve.segments();
    let index = (draw.unit() * segments.len() as f64) as usize;
    let here = &segments[index];
    if corners && index > 0 {
        let before = segments[index - 1].tangent(1.0);
        let turn = wrap_angle(here.tangent(0.0) - before);
        let concave = (turn > 1e-3) == (flip == 0.0);
        return (here.start(), before + draw.unit() * turn + FRAC_PI_2 + flip, concave);
    }
    let t = draw.unit();
    (here.point(t), here.tangent(t) + FRAC_PI_2 + flip, false)
}

/// Largest slope of the whisker at the contact (rad).
const SLOPE: f64 = PI;

struct Case {
    whisker: MountedWhisker,
    robot: Pose2,
    moment: (f64, f64),
    true_moment: f64,
}

/// A robot whose whisker touches the map in a random single contact, and an interval that holds its moment.
fn case(map: &Map, draw: &mut Random, friction: f64) -> Option<Case> {
    let mount = Pose2::new(draw.signed(0.05), draw.signed(0.05), draw.signed(PI));
    let whisker = MountedWhisker { robot_from_whisker: mount, friction, ..MountedWhisker::default() };
    let (lean, beam) = (friction.atan(), &whisker.beam);
    let corners = draw.unit() < 0.4;
    let (place, normal, concave) = foothold(map, draw, corners);
    let tip = draw.unit() < 0.6;
    let (s_a, beta, off) = if tip {
        let beta = draw.between(-lean, FRAC_PI_2);
        (beam.length, beta, draw.signed(lean))
    } else {
        (beam.length * draw.between(0.02, 1.0), draw.signed(lean), 0.0)
    };
    let held = friction > 0.0 || (concave && tip);
    let (slope, moment, contact) = if held && draw.unit() < 0.4 {
        let (slope, moment, contact) = with_inflection(FRAC_PI_2 - beta, draw.between(3.1, 8.0))?;
        (slope, moment * beam.flexural_rigidity / s_a, contact * s_a)
    } else {
        let t = draw.between(0.05, 4.0);
        let force = (t / s_a).powi(2) * beam.flexural_rigidity;
        let bend = elastica::bend(beam.flexural_rigidity, force, s_a, beta).filter(|bend| bend.moment > 0.0)?;
        (bend.phi_a, bend.moment, bend.contact)
    };
    if slope > SLOPE {
        return None;
    }
    let side = draw.sign();
    // The wall's normal in the whisker frame: the force's direction less its lean, or the whisker's own normal.
    let psi = slope + FRAC_PI_2 + if tip { beta - off } else { 0.0 };
    let heading = normal - side * psi;
    let contact = Vec2::new(contact.x, side * contact.y);
    let base = place - contact.rotated(heading);
    let moment = side * moment;
    let (below, above) = (draw.between(0.0, 0.1), draw.between(0.0, 0.1));
    let (a, b) = (moment * (1.0 - below), moment * (1.0 + above));
    let robot = Pose2::new(base.x, base.y, heading).compose(mount.inverse());
    Some(Case { whisker, robot, moment: (a.min(b), a.max(b)), true_moment: moment })
}

/// Slope, moment and contact of a whisker of unit length and stiffness with one inflection, by small steps: a pendulum
/// let go `amplitude` before its balance, after the time `t`.
fn with_inflection(amplitude: f64, t: f64) -> Option<(f64, f64, Vec2)> {
    let steps = 4000;
    let h = t / f64::from(steps);
    let (mut w, mut speed, mut rests) = (-amplitude, 0.0, 0);
    let mut sum = Vec2::ZERO;
    for _ in 0..steps {
        let half = w + 0.5 * h * speed;
        let faster = speed - h * half.sin();
        rests += usize::from(speed * faster < 0.0);
        sum += Vec2::from_angle(half) * (h / t);
        (w, speed) = (half + 0.5 * h * faster, faster);
    }
    let (sin, cos) = w.sin_cos();
    let contact = Vec2::new(cos * sum.x + sin * sum.y, sin * sum.x - cos * sum.y);
    (rests == 1 && speed < 0.0).then_some((w + amplitude, speed * t, contact))
}

/// A whisker whose map has the right scale.
fn told(whisker: &MountedWhisker) -> UncertainWhisker {
    UncertainWhisker::new(whisker, 0.0, SLOPE)
}

/// A uniform whisker with this coefficient of friction.
fn rubbed(friction: f64) -> UncertainWhisker {
    told(&MountedWhisker { friction, ..MountedWhisker::default() })
}

/// A cell of random shape with the state inside, sometimes in its very corner.
fn cell_around(state: Pose2, draw: &mut Random) -> Parallelotope {
    let size = 10f64.powf(draw.between(-3.8, -1.2));
    let sides = [0; 3].map(|_| [draw.signed(size), draw.signed(size), draw.signed(size * 6.0)]);
    let w = [0; 3].map(|_| if draw.unit() < 0.3 { draw.sign() } else { draw.signed(1.0) });
    let at = |a: usize| (0..3).map(|j| w[j] * sides[j][a]).sum::<f64>();
    let center = Pose2::new(state.x - at(0), state.y - at(1), state.theta - at(2));
    Parallelotope { center, sides, anchor: 0, seen: 0, missed: 0, rest_until: 0, patience: 8, is_fresh: false }
}

/// Whether the state is in the cell, up to rounding.
fn holds(cell: &Parallelotope, state: Pose2) -> bool {
    let [a, b, c] = cell.sides;
    let d = [state.x - cell.center.x, state.y - cell.center.y, wrap_angle(state.theta - cell.center.theta)];
    let det = |p: [f64; 3], q: [f64; 3], r: [f64; 3]| {
        p[0] * (q[1] * r[2] - q[2] * r[1]) - p[1] * (q[0] * r[2] - q[2] * r[0]) + p[2] * (q[0] * r[1] - q[1] * r[0])
    };
    let all = det(a, b, c);
    [det(d, b, c), det(a, d, c), det(a, b, d)].iter().all(|w| (w / all).abs() <= 1.0 + 1e-6)
}

fn no_true_state_is_ruled_out(friction: f64, seed: u64, trials: usize) {
    let map = map();
    let ground = BoundaryLevels::new(&map);
    let options = PossibilisticOptions { largest_slope: SLOPE, ..PossibilisticOptions::default() };
    let of = |size, count| super::contact_tables::tables(size, count, &rubbed(friction), &options);
    let (tables, next) = (
        of(super::contact_tables::FIRST_TABLE, super::contact_tables::TABLES),
        of(super::contact_tables::NEXT_TABLE, super::contact_tables::NEXT_TABLES),
    );
    let finer = ContactTable::from(PressTable::new(128, 96, friction.atan(), SLOPE));
    let mut draw = Random(seed);
    let mut cut = 0;
    let mut tried = 0;
    while tried < trials {
        let Some(case) = case(&map, &mut draw, friction) else { continue };
        tried += 1;
        let mut touch = ReadingContacts::new(&told(&case.whisker), &tables, case.moment.0, case.moment.1);
        if tried % 3 > 0 {
            next.iter().rev().for_each(|table| touch.add_finer(&told(&case.whisker), table));
        }
        if tried % 3 > 1 {
            touch.add_finer(&told(&case.whisker), &finer);
        }
        for _ in 0..3 {
            // The state at another row, with the odometry in between off by as much as it may.
            let step = Pose2::new(draw.signed(0.1), draw.signed(0.1), draw.signed(1.0));
            let (place, turn) = (draw.between(0.0, 1e-3), draw.between(0.0, 1e-2));
            let wrong = Vec2::from_angle(draw.signed(PI)) * place;
            let then = case.robot.compose(step.inverse());
            let felt = Pose2::new(step.x + wrong.x, step.y + wrong.y, step.theta + draw.sign() * turn);
            let mut cell = cell_around(then, &mut draw);
            assert!(holds(&cell, then));
            let before = cell.volume();
            let view = BaseView::new(&cell, felt, (place, turn), case.whisker.robot_from_whisker);
            let left = contractor::contract(&view, &touch, &ground, &mut 0);
            let left = left.unwrap_or_else(|| panic!("lost: {case:?} {cell:?}"));
            cell.contract_to(&left);
            assert!(holds(&cell, then), "cut away: {case:?} {cell:?}");
            cut += usize::from(cell.volume() < 0.5 * before);
        }
    }
    // Friction, which also holds whiskers with an inflection, leaves little to cut for a single reading.
    assert!(cut > if friction > 0.0 { 10 } else { trials / 10 }, "{cut}");
}

/// A whisker and a map's scale as they may be told of the case's whisker, which stands in the map's metres, with bounds on
/// what is wrong with them.
fn told_wrong(case: &Case, draw: &mut Random) -> UncertainWhisker {
    let mut share =
        |most: f64| (draw.between(0.0, most), if draw.unit() < 0.5 { draw.sign() } else { draw.signed(1.0) });
    let (length, rigidity, scale) = (share(0.05), share(0.1), share(0.04));
    let (place, theta) = (share(3e-3), share(0.1));
    let larger = 1.0 + scale.0 * scale.1;
    let mut whisker = case.whisker.clone();
    let true_length = whisker.beam.length * larger;
    whisker.beam.length = true_length / (1.0 + length.0 * length.1);
    whisker.errors.length = length.0 * whisker.beam.length;
    whisker.beam.flexural_rigidity *= larger / (1.0 + rigidity.0 * rigidity.1);
    whisker.errors.rigidity = rigidity.0;
    // An elastic base, which the true moment has turned, somewhere in the interval.
    if draw.unit() < 0.5 {
        whisker.beam.base_stiffness = 10f64.powf(draw.between(-2.0, 0.0));
    }
    let Pose2 { x, y, theta: turned } = whisker.robot_from_whisker;
    let off = Vec2::from_angle(draw.signed(PI)) * place.0;
    let heading = turned - case.true_moment / whisker.beam.base_stiffness;
    whisker.robot_from_whisker = Pose2::new(x * larger + off.x, y * larger + off.y, heading + theta.0 * theta.1);
    whisker.errors.mount = [off.x.abs(), off.y.abs(), theta.0];
    UncertainWhisker::new(&whisker, scale.0, SLOPE)
}

/// Errors of whisker, mount, base and map at any place within their bounds.
#[test]
fn no_true_state_is_ruled_out_with_declared_errors() {
    let map = map();
    let ground = BoundaryLevels::new(&map);
    let mut draw = Random(61);
    let options = PossibilisticOptions { largest_slope: SLOPE, ..PossibilisticOptions::default() };
    for friction in [0.0, 0.3] {
        let tables = super::contact_tables::tables(
            super::contact_tables::NEXT_TABLE,
            super::contact_tables::NEXT_TABLES,
            &rubbed(friction),
            &options,
        );
        let level = BoundaryLevels::new(&map).clustered;
        let mut tried = 0;
        while tried < 2000 {
            let Some(case) = case(&map, &mut draw, friction) else { continue };
            tried += 1;
            let whisker = told_wrong(&case, &mut draw);
            let touch = ReadingContacts::new(&whisker, &tables, case.moment.0, case.moment.1);
            let mut cell = cell_around(case.robot, &mut draw);
            let view = BaseView::new(&cell, Pose2::IDENTITY, (0.0, 0.0), touch.robot_from_whisker);
            let left = contractor::contract(&view.with_base(touch.base), &touch, &ground, &mut 0);
            cell.contract_to(&left.unwrap_or_else(|| panic!("lost: {case:?} {whisker:?}")));
            assert!(holds(&cell, case.robot), "cut away: {case:?} {whisker:?}");
            if tried % 200 == 0 {
                let cells = initial_cover::initial_cells(&level, None, &touch, (0, PoseSlack::default()));
                assert!(cells.iter().any(|cell| holds(cell, case.robot)), "not born: {case:?} {whisker:?}");
            }
        }
    }
}

impl core::fmt::Debug for Case {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{:?} {:?} {:?}", self.robot, self.moment, self.whisker.robot_from_whisker)
    }
}

#[test]
fn no_true_state_is_ruled_out_without_friction() {
    no_true_state_is_ruled_out(0.0, 1, 4000);
}

#[test]
fn no_true_state_is_ruled_out_with_friction() {
    no_true_state_is_ruled_out(0.3, 2, 10_000);
}

#[test]
fn where_the_whisker_stood_before_changes_no_answer() {
    let map = map();
    let ground = BoundaryLevels::new(&map);
    let options = PossibilisticOptions { largest_slope: SLOPE, ..PossibilisticOptions::default() };
    let tables = super::contact_tables::tables(
        super::contact_tables::NEXT_TABLE,
        super::contact_tables::NEXT_TABLES,
        &rubbed(0.0),
        &options,
    );
    let mut draw = Random(41);
    let (mut tried, mut saved) = (0, 0);
    while tried < 300 {
        let Some(case) = case(&map, &mut draw, 0.0) else { continue };
        tried += 1;
        let touch = || ReadingContacts::new(&told(&case.whisker), &tables, case.moment.0, case.moment.1);
        let used = touch();
        for _ in 0..8 {
            let mut cells = [cell_around(case.robot, &mut draw); 2];
            let mut comparisons = [0; 2];
            for ((cell, comparisons), touch) in cells.iter_mut().zip(&mut comparisons).zip([&used, &touch()]) {
                let view = BaseView::new(cell, Pose2::IDENTITY, (0.0, 0.0), case.whisker.robot_from_whisker);
                cell.contract_to(&contractor::contract(&view, touch, &ground, comparisons).unwrap());
            }
            assert_eq!(cells[0], cells[1], "{case:?}");
            saved += usize::from(comparisons[0] < comparisons[1]);
        }
    }
    assert!(saved > tried / 10, "{saved}");
}

#[test]
fn cut_after_cut_makes_no_cell_wide() {
    // Strips that each cut off little, slanted at random: what is left of a cell must not reach beyond its surroundings.
    let mut draw = Random(52);
    for trial in 0..200 {
        let size = draw.between(1e-3, 0.02);
        let mut cell = cell_around(Pose2::IDENTITY, &mut draw);
        cell.sides = [[size, 0.0, 0.0], [0.0, size, 0.0], [0.0, 0.0, 4.0 * size]];
        let wide = cell.reach();
        for _ in 0..300 {
            let form = [0; 3].map(|_| draw.signed(1.0));
            let total: f64 = form.iter().map(|k| k.abs()).sum();
            let half = draw.between(0.75, 0.95) * total;
            cell.contract(&form, (-half, half));
        }
        let reach = cell.reach();
        for (axis, most) in [0.02, 0.02, 0.05].into_iter().enumerate() {
            assert!(reach[axis] <= wide[axis].max(most) * (1.0 + 1e-9), "trial {trial}: {wide:?} {reach:?}");
        }
    }
}

#[test]
fn a_stage_is_over_when_more_work_rules_out_little() {
    let stages = |shrinks: f64, grows: f64| {
        let (mut progress, mut done, mut volume, mut cells) = (StageProgress::default(), 0, 1.0, 100.0);
        let rounds = (0..30).map(|_| {
            let told = progress.note(cells as usize, done, volume);
            done += 5_000;
            volume *= shrinks;
            cells *= grows;
            told
        });
        let (grow, stall): (Vec<bool>, Vec<bool>) = rounds.unzip();
        (grow.iter().position(|&b| b), stall.iter().position(|&b| b))
    };
    assert_eq!(stages(0.8, 0.9), (None, None));
    // Five rounds are 25,000 pieces of work, and 1.1 ^ 5 is 1.6.
    assert_eq!(stages(1.0, 1.0), (None, Some(5)));
    assert_eq!(stages(1.0, 1.1), (Some(5), Some(5)));
}

#[test]
fn every_true_state_is_born() {
    let map = map();
    let level = BoundaryLevels::new(&map).clustered;
    assert!(level.all.all.iter().any(|piece| matches!(piece, ThickPiece::Vertex(v) if v.spread > 0.0)));
    for (friction, seed) in [(0.0, 3), (0.2, 4)] {
        let table = [ContactTable::from(PressTable::new(24, 24, f64::atan(friction), SLOPE))];
        let mut draw = Random(seed);
        let mut tried = 0;
        while tried < 20 {
            let Some(case) = case(&map, &mut draw, friction) else { continue };
            tried += 1;
            let touch = ReadingContacts::new(&told(&case.whisker), &table, case.moment.0, case.moment.1);
            let cells = initial_cover::initial_cells(&level, None, &touch, (0, PoseSlack::default()));
            assert!(cells.iter().any(|cell| holds(cell, case.robot)), "{case:?}");
        }
    }
}

#[test]
fn growing_and_moving_keep_what_they_must() {
    let mut draw = Random(9);
    for _ in 0..20_000 {
        let state = Pose2::new(draw.signed(1.0), draw.signed(1.0), draw.signed(PI));
        let mut cell = cell_around(state, &mut draw);
        let (place, turn) = (draw.between(0.0, 1e-3), draw.between(0.0, 1e-2));
        let off = Vec2::from_angle(draw.signed(PI)) * place;
        let moved = Pose2::new(state.x + off.x, state.y + off.y, state.theta + draw.sign() * turn);
        cell.inflate(place, turn);
        assert!(holds(&cell, moved), "{cell:?}");
        let step = Pose2::new(draw.signed(0.1), draw.signed(0.1), draw.signed(PI));
        cell.transport(step, 1);
        assert!(holds(&cell, moved.compose(step)), "{cell:?}");
    }
}

#[test]
fn a_large_set_of_one_reading_meets_finer_tables() {
    let map = map();
    let mut draw = Random(31);
    for _ in 0..2 {
        let free = |case: &Case| map.is_free(case.robot.compose(case.whisker.robot_from_whisker).position());
        let case = core::iter::repeat_with(|| case(&map, &mut draw, 0.0)).flatten().find(free).unwrap();
        let robot = Robot { whiskers: vec![case.whisker.clone()], ..Robot::default() };
        let ends = |last_work: usize| {
            let options = PossibilisticOptions { last_work, largest_slope: SLOPE, ..PossibilisticOptions::default() };
            let mut set = super::PossibleSet::new(&map, &robot, options);
            set.update(&map, Pose2::IDENTITY, &[Interval::new(case.moment.0, case.moment.1)], None);
            assert!(set.has_first_tables());
            set.finish(&map);
            assert!(set.cells.iter().any(|cell| holds(cell, case.robot)), "{case:?}");
            set
        };
        let (none, much) = (ends(0), ends(2_000_000));
        assert!(none.has_first_tables() && !much.has_first_tables());
        assert!(much.volume() < 0.95 * none.volume(), "{} {}", much.volume(), none.volume());
    }
}

#[test]
fn pieces_cover_the_map() {
    let map = map();
    for grain in [FINE, COARSE] {
        let pieces = PieceIndex::new(&map, grain);
        pieces_cover(&map, &pieces.all);
        pieces_cover(&map, &pieces.clustered().all);
    }
}

#[test]
fn leaves_cover_what_their_pieces_do() {
    let map = map();
    let pieces = PieceIndex::with_leaves(&map, FINE);
    let concavity = pieces.concavity();
    let leaves_of = |pieces: &PieceIndex, piece: &ThickPiece| match piece {
        ThickPiece::Edge(e) if e.leaves.0 < e.leaves.1 => {
            pieces.leaves[e.leaves.0 as usize..e.leaves.1 as usize].to_vec()
        }
        other => vec![*other],
    };
    let leaves: Vec<ThickPiece> = pieces.all.iter().flat_map(|piece| leaves_of(&pieces, piece)).collect();
    assert!(leaves.len() > 2 * pieces.all.len(), "{} of {}", leaves.len(), pieces.all.len());
    pieces_cover(&map, &leaves);
    // Each of them lies within its piece, so that a look at the piece is a look at all of them.
    for piece in &pieces.all {
        let ThickPiece::Edge(edge) = piece else { continue };
        for leaf in leaves_of(&pieces, piece) {
            let (normal, slack) = match leaf {
                ThickPiece::Edge(e) => (e.normal, e.slack),
                ThickPiece::Vertex(v) => (v.normal, v.slack),
            };
            assert!(wrap_angle(normal - edge.normal).abs() + slack <= edge.slack + 1e-5, "{leaf:?} of {edge:?}");
            for end in leaf.chord() {
                let (along, off) = (edge.along.dot(end - edge.start), edge.along.cross(end - edge.start));
                let sagitta = edge.sagitta + 1e-9;
                assert!(
                    off.abs() <= sagitta && (-sagitta..=edge.length + sagitta).contains(&along),
                    "{leaf:?} of {edge:?}"
                );
            }
        }
    }
    // What can hold a tip is among the leaves of the hollow pieces.
    let holds = |piece: &&ThickPiece| match piece {
        ThickPiece::Edge(e) => e.concavity > 0.0,
        ThickPiece::Vertex(v) => v.concavity > 0.0,
    };
    let of_hollow: Vec<ThickPiece> = concavity.all.iter().flat_map(|piece| leaves_of(&concavity, piece)).collect();
    assert!(leaves.iter().filter(holds).all(|leaf| of_hollow.contains(leaf)));
}

fn pieces_cover(map: &Map, pieces: &[ThickPiece]) {
    let edges = pieces.iter().filter(|p| matches!(p, ThickPiece::Edge(_))).count();
    assert!(edges > 10, "{edges} edges, {} vertices", pieces.len() - edges);
    let mut draw = Random(12);
    for _ in 0..5000 {
        let corners = draw.unit() < 0.5;
        let (place, normal, _) = foothold(map, &mut draw, corners);
        let covered = pieces.iter().any(|piece| match piece {
            ThickPiece::Edge(e) => {
                let (along, off) = (e.along.dot(place - e.start), e.along.cross(place - e.start));
                off.abs() <= e.sagitta
                    && (-e.sagitta..=e.length + e.sagitta).contains(&along)
                    && wrap_angle(normal - e.normal).abs() <= e.slack
            }
            ThickPiece::Vertex(v) => {
                v.point.distance(place) < v.spread + 1e-9 && wrap_angle(normal - v.normal).abs() <= v.slack + 1e-9
            }
        });
        assert!(covered, "{place:?} {normal}");
    }
}

#[test]
fn finely_cut_boundary_is_searched_by_its_length() {
    // A rough circle of 1.26 m, cut into edges of 0.6 mm and of 0.08 mm.
    let bundles = |edges: usize| {
        let edge = 2.0 * PI * 0.2 / edges as f64;
        let corner =
            |k: usize| Vec2::from_angle(k as f64 / edges as f64 * 2.0 * PI) * (0.2 + 0.2 * edge * (k % 2) as f64);
        let corners: Vec<Vec2> = (0..edges).map(corner).collect();
        let outline = Boundary::new(Role::Arena, Curve::polyline(&corners, true).unwrap(), None).unwrap();
        let level = BoundaryLevels::new(&Map::new(vec![outline]).unwrap());
        assert!(level.coarse.all.all.len() > edges);
        level.clustered.all.all.len()
    };
    let (coarse, fine) = (bundles(2000), bundles(16_000));
    assert!(coarse < 80 && fine < 80, "{coarse} {fine}");
}

/// A whisker that lies on one wall of a corner with its tip against the other may touch twice; one that stands on a straight wall
/// far from corners may not.
#[test]
fn two_contacts_are_thought_of_where_there_are_corners() {
    let map = map();
    let ground = BoundaryLevels::new(&map);
    let (whisker, mut draw) = (told(&MountedWhisker::default()), Random(71));
    let two = TwoContacts::new(&ground.coarse.all, whisker.longest, 0.0);
    let tables = super::contact_tables::tables(
        super::contact_tables::FIRST_TABLE,
        super::contact_tables::TABLES,
        &rubbed(0.0),
        &PossibilisticOptions::default(),
    );
    let may = |base: Pose2, moment: f64| {
        let touch = ReadingContacts::new(&whisker, &tables, 0.95 * moment, 1.05 * moment);
        let sides = [[1e-5, 0.0, 0.0], [0.0, 1e-5, 0.0], [0.0, 0.0, 1e-4]];
        let cell = Parallelotope { center: base, sides, ..cell_around(base, &mut Random(1)) };
        let view = BaseView::new(&cell, Pose2::IDENTITY, (0.0, 0.0), Pose2::IDENTITY);
        assert!(two.is_near(&view, whisker.longest) || !two.may_explain(&view, &touch, &mut 0));
        two.may_explain(&view, &touch, &mut 0)
    };
    for _ in 0..100 {
        // Into the corner at (0.5, 0), towards the lower wall and the one to the right; pushed to the left.
        let base = Pose2::new(0.44 + draw.signed(2e-3), 0.012 + draw.signed(2e-3), -0.5 + draw.signed(0.1));
        assert!(may(base, 4e-3), "{base:?}");
        // The middle of the long wall at the left, head-on and aslant.
        let base = Pose2::new(0.06, 0.3 + draw.signed(0.01), PI + draw.signed(0.7));
        assert!(!may(base, draw.sign() * draw.between(1e-4, 1e-3)), "{base:?}");
    }
}
