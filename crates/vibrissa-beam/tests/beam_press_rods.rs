//! The tables of rods that are not uniform against marches of random loads: no equilibrium that a chain of links finds stable,
//! held or sliding, is left out.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "../../vibrissa/tests/data/random.rs"]
mod random;

use core::f64::consts::{FRAC_PI_2, PI, TAU};
use random::Random;
use vibrissa_beam::beam::press::{PressEntry, PressSlice, PressTable, RodContacts, RodPressTable};
use vibrissa_beam::beam::{Bend, Rod, Stretch, Whisker};
use vibrissa_beam::plane::Vec2;

/// Links of the chain.
const LINKS: usize = 64;
/// Curvature of a boundary, over the whisker's length, below which a shape that needs to be held cannot be.
const HARDLY_CURVED: f64 = 0.25;

fn holds(entry: &PressEntry, psi: f64, p: Vec2) -> bool {
    let rest = p - entry.center - entry.by_direction * (psi - entry.middle);
    let square = entry.by_moment.norm_squared();
    let share = if square > 0.0 { (rest.dot(entry.by_moment) / square).clamp(-1.0, 1.0) } else { 0.0 };
    (psi - entry.middle).abs() <= entry.half + 1e-12 && (rest - entry.by_moment * share).norm() <= entry.radius
}

/// Whether the slice knows a contact, and whether it does where the boundary does not hold it.
fn known(slice: &PressSlice, psi: f64, p: Vec2) -> [bool; 2] {
    let psi = psi.rem_euclid(TAU);
    let all = || slice.between(psi, psi).iter().filter(|entry| holds(entry, psi, p));
    [all().next().is_some(), all().any(|entry| !entry.inflected)]
}

/// What keeps a contact where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Held {
    Pinned,
    Sliding(f64),
}

/// The ends of links, shorter where the whisker is thin.
fn joints(whisker: &Whisker, s_a: f64) -> Vec<f64> {
    let parts = 64 * LINKS;
    let step = s_a / parts as f64;
    let mut dense = vec![0.0];
    for k in 0..parts {
        let thin = whisker.rigidity_at((k as f64 + 0.5) * step).powf(-0.25).min(100.0);
        dense.push(dense[k] + (1.0 + thin) * step);
    }
    let whole = dense[parts];
    let at = |share: f64| {
        let k = dense.partition_point(|&d| d < share * whole).clamp(1, parts);
        (k as f64 - (dense[k] - share * whole) / (dense[k] - dense[k - 1])) * step
    };
    (0..=LINKS).map(|k| at(k as f64 / LINKS as f64)).collect()
}

/// Whether the energy of a chain in this shape rises with every change of its links' slopes that the hold allows.
fn is_stable(whisker: &Whisker, bend: &Bend, tip: bool, held: Held) -> bool {
    let ends = joints(whisker, bend.s_a);
    let middle = |k: usize| 0.5 * (ends[k] + ends[k + 1]);
    let slopes: Vec<f64> = (0..LINKS).map(|k| bend.point_at(middle(k)).slope).collect();
    let direction = bend.phi_a + bend.beta + FRAC_PI_2;
    let push = Vec2::from_angle(direction) * bend.force;
    let normal = Vec2::from_angle(direction) * bend.force.signum();
    let along = Vec2::new(normal.y, -normal.x);
    let mut h = vec![vec![0.0; LINKS]; LINKS];
    // Joints and tapers lie between the middles.
    let spring = |from: f64, to: f64| {
        let parts = 32;
        let at = |i: usize| from + (to - from) * (i as f64 + 0.5) / parts as f64;
        let soft = (0..parts).map(|i| 1.0 / whisker.rigidity_at(at(i))).sum::<f64>() / parts as f64;
        1.0 / (soft * (to - from))
    };
    for k in 0..LINKS {
        let stiffness = spring(if k == 0 { 0.0 } else { middle(k - 1) }, middle(k));
        h[k][k] += stiffness + (ends[k + 1] - ends[k]) * push.dot(Vec2::from_angle(slopes[k]));
        if k > 0 {
            h[k - 1][k - 1] += stiffness;
            h[k][k - 1] -= stiffness;
            h[k - 1][k] -= stiffness;
        }
    }
    let scale = h.iter().enumerate().map(|(k, row)| row[k].abs()).fold(0.0, f64::max);
    let mut constrain = |of: &dyn Fn(f64) -> f64, stiffness: f64| {
        let row: Vec<f64> = (0..LINKS).map(|k| (ends[k + 1] - ends[k]) * of(slopes[k])).collect();
        for i in 0..LINKS {
            for j in 0..LINKS {
                h[i][j] += stiffness * row[i] * row[j];
            }
        }
    };
    let moves = |d: Vec2| move |slope: f64| d.dot(Vec2::from_angle(slope + FRAC_PI_2));
    let rigid = 1e6 * scale / (bend.s_a * bend.s_a);
    constrain(&moves(normal), rigid);
    match held {
        Held::Pinned => constrain(&moves(along), rigid),
        Held::Sliding(curvature) => constrain(&moves(along), bend.force.abs() * curvature),
    }
    if !tip {
        // A side keeps its slope, or slides along itself: its end turns with the way.
        let curvature = if let Held::Sliding(curvature) = held { curvature } else { 0.0 };
        let stiffness = spring(middle(LINKS - 1), bend.s_a);
        let mut row: Vec<f64> =
            (0..LINKS).map(|k| -curvature * (ends[k + 1] - ends[k]) * moves(along)(slopes[k])).collect();
        row[LINKS - 1] += 1.0;
        for i in 0..LINKS {
            for j in 0..LINKS {
                h[i][j] += stiffness * row[i] * row[j];
            }
        }
    }
    is_positive(h)
}

fn is_positive(mut h: Vec<Vec<f64>>) -> bool {
    for k in 0..h.len() {
        let pivot = h[k][k];
        if pivot <= 0.0 {
            return false;
        }
        for i in k + 1..h.len() {
            let share = h[i][k] / pivot;
            if share != 0.0 {
                #[allow(clippy::needless_range_loop, reason = "two rows of one matrix")]
                for j in k + 1..h.len() {
                    h[i][j] -= share * h[k][j];
                }
            }
        }
    }
    true
}

fn interval(draw: &mut Random, mu: f64) -> (f64, f64) {
    let (below, above) = (mu.abs() * draw.between(0.0, 0.06), mu.abs() * draw.between(0.0, 0.06));
    match draw.between(0.0, 3.0) as u32 {
        0 => (mu, mu + above + 1e-12),
        1 => (mu - below - 1e-12, mu),
        _ => (mu - below - 0.01 * draw.unit(), mu + above + 0.01 * draw.unit()),
    }
}

/// Loads that are in the table, and stable ones among them.
#[derive(Debug, Default)]
struct Counts {
    tips: usize,
    sides: usize,
    sliding: usize,
    entries: usize,
    unstable: usize,
}

fn mirrored(whisker: &Whisker) -> Whisker {
    Whisker { curvature: -whisker.curvature, curvature_rise: whisker.curvature_rise.map(|term| -term), ..*whisker }
}

fn none_is_left_out(
    whisker: &Whisker,
    table: &RodPressTable,
    friction: f64,
    stretch: f64,
    trials: usize,
    seed: u64,
) -> Counts {
    let mut draw = Random(seed);
    let mut counts = Counts::default();
    for _ in 0..trials {
        let side = draw.sign();
        // The whisker as it may be.
        let longer = 1.0 + draw.signed(stretch);
        let mut rises = whisker.curvature_rise;
        rises.iter_mut().enumerate().for_each(|(k, term)| *term *= longer.powi(k as i32 + 2));
        let actual = Whisker { curvature: whisker.curvature * longer, curvature_rise: rises, ..*whisker };
        let seen = if side > 0.0 { actual } else { mirrored(&actual) };
        let rod: Rod = seen.rod().unwrap();
        let tip = draw.unit() < 0.5;
        let skew = |draw: &mut Random| if draw.unit() < 0.3 { draw.unit().powi(4) } else { draw.unit() };
        let (beta, s_a) = if tip {
            let share = skew(&mut draw);
            let share = if draw.unit() < 0.5 { share } else { 1.0 - share };
            (-friction + (FRAC_PI_2 + friction) * share, 1.0)
        } else {
            (draw.signed(friction), skew(&mut draw).max(1e-4))
        };
        let root = if draw.unit() < 0.5 { draw.between(0.0, 4.0) } else { 10f64.powf(draw.between(-2.0, 1.5)) };
        let force = root * root / rod.slope_compliance(s_a);
        let Some((contact, slope, moment)) = rod.contact_under(force, s_a, beta) else { continue };
        let (_, rest, _) = rod.contact_under(0.0, s_a, beta).unwrap();
        if (slope - rest).abs() > PI || (s_a < 0.005 && (slope - rest).abs() > 0.9) {
            continue;
        }
        let Some(bend) = rod.pushed(force, s_a, beta) else { continue };
        let pinned = if tip || friction > 0.0 { Held::Pinned } else { Held::Sliding(seen.curvature_at(s_a)) };
        let (lo, hi) = interval(&mut draw, moment);
        let slice = table.slice(side, lo, hi);
        let psi = slope + FRAC_PI_2 + if tip { beta } else { 0.0 };
        let found = known(&slice, psi, contact);
        assert!(
            found[0] || !is_stable(&seen, &bend, tip, pinned),
            "{} side {side} psi {psi} beta {beta} s_a {s_a} root {root} slope {slope} moment {moment} in {lo}..{hi}: {contact:?}; {:?}",
            if tip { "tip" } else { "side" },
            slice.between(psi.rem_euclid(TAU), psi.rem_euclid(TAU))
        );
        if !found[0] {
            counts.unstable += 1;
            continue;
        }
        if tip && friction <= 0.0 && !found[1] {
            assert!(
                !is_stable(&seen, &bend, tip, Held::Sliding(HARDLY_CURVED)),
                "needs no hold: psi {psi} beta {beta} root {root} slope {slope} moment {moment}"
            );
        } else if tip {
            counts.sliding += 1;
        }
        if tip {
            counts.tips += 1
        } else {
            counts.sides += 1
        }
        counts.entries += slice.entries().len();
    }
    assert!(counts.tips > trials / 50 && counts.sides > trials / 12, "{counts:?}");
    counts
}

fn unit(change: impl FnOnce(&mut Whisker)) -> Whisker {
    let mut whisker = Whisker { length: 1.0, flexural_rigidity: 1.0, ..Whisker::default() };
    change(&mut whisker);
    whisker
}

fn wires(list: &[(f64, f64, f64)]) -> Whisker {
    let stretches: Vec<Stretch> = list
        .iter()
        .map(|&(length, flexural_rigidity, tip_ratio)| Stretch { length, flexural_rigidity, tip_ratio, diameter: None })
        .collect();
    Whisker::of_stretches(&stretches).unwrap()
}

/// Every kind of whisker, up to the ends of what a robot file may say.
fn kinds() -> Vec<(&'static str, Whisker)> {
    vec![
        ("uniform", unit(|_| {})),
        ("tapered to a half", unit(|w| w.tip_ratio = 0.5)),
        ("tapered to a tenth", unit(|w| w.tip_ratio = 0.1)),
        ("tapered to a thousandth", unit(|w| w.tip_ratio = 1e-3)),
        ("curved", unit(|w| w.curvature = 0.8)),
        ("curved to a circle", unit(|w| w.curvature = 6.2)),
        (
            "curved one way and the other",
            unit(|w| {
                w.curvature = 1.5;
                w.curvature_rise[0] = -3.5;
            }),
        ),
        ("curved and tapered", unit(|w| (w.curvature, w.tip_ratio) = (-2.0, 0.2))),
        ("curlier towards the tip", unit(|w| (w.curvature_rise[4], w.tip_ratio) = (5.0, 0.3))),
        ("two wires", wires(&[(0.4, 1.0, 1.0), (0.6, 0.1, 1.0)])),
        ("stiff behind soft", wires(&[(0.3, 1.0, 1.0), (0.05, 1e-3, 1.0), (0.65, 1.0, 1.0)])),
        ("stiffer towards the tip", wires(&[(0.3, 1.0, 1.5), (0.7, 5.0, 1.2)])),
        ("rigid with a soft tip", wires(&[(0.6, 1.0, 1.0), (0.4, 1e-4, 0.5)])),
    ]
}

/// The tables that localization uses: buckets in a quarter turn, and what patches leave.
const TABLES: [(usize, f64); 3] = [(8, 4.7e-2), (16, 1.9e-2), (64, 1.5e-3)];

fn check(names: &[&str], (friction, stretch): (f64, f64), trials: usize) {
    for (seed, (name, whisker)) in kinds().into_iter().enumerate().filter(|(_, (name, _))| names.contains(name)) {
        let mut contacts = RodContacts::new(&whisker, friction, PI, stretch).unwrap();
        for (k, (buckets, width)) in TABLES.into_iter().enumerate() {
            contacts.refine(width);
            let table = contacts.table(buckets, width);
            println!("{name} {buckets}:");
            none_is_left_out(&whisker, &table, friction, stretch, trials, (100 * k + seed) as u64);
        }
    }
}

#[test]
fn no_contact_of_tapered_whiskers_is_left_out() {
    check(&["uniform", "tapered to a half", "tapered to a tenth", "tapered to a thousandth"], (0.0, 0.0), 200);
}

#[test]
fn no_contact_of_curved_whiskers_is_left_out() {
    let names = ["curved", "curved to a circle", "curved one way and the other", "curved and tapered"];
    check(&names, (0.0, 0.0), 200);
    check(&["curlier towards the tip"], (0.0, 0.03), 200);
}

#[test]
fn no_contact_of_several_wires_is_left_out() {
    let names = ["two wires", "stiff behind soft", "stiffer towards the tip", "rigid with a soft tip"];
    check(&names, (0.0, 0.0), 200);
}

#[test]
fn no_contact_with_friction_or_of_another_length_is_left_out() {
    check(&["tapered to a half", "two wires", "curved and tapered"], (0.3, 0.04), 150);
    check(&["curved"], (0.9, 0.0), 150);
}

/// Of a uniform whisker the closed form knows all: what the march adds is little.
#[test]
fn little_is_added() {
    let uniform = unit(|_| {});
    let mut contacts = RodContacts::new(&uniform, 0.0, PI, 0.0).unwrap();
    contacts.refine(1.5e-3);
    let (rod, closed) = (contacts.table(64, 1.5e-3), PressTable::new(64, 64, 0.0, PI));
    assert!(contacts.table(8, 4.7e-2).patches() < rod.patches());
    let area = |slice: &PressSlice| -> f64 {
        let of = |e: &PressEntry| 2.0 * e.half * (2.0 * e.by_moment.norm() + 2.0 * e.radius) * 2.0 * e.radius;
        slice.entries().iter().map(of).sum()
    };
    for mu in [0.05, 0.3, 0.9, 1.5] {
        let (ours, least) = (rod.slice(1.0, 0.95 * mu, 1.05 * mu), closed.slice(0.95 * mu, 1.05 * mu));
        println!("mu {mu}: {:.1e} against {:.1e}", area(&ours), area(&least));
        assert!(area(&ours) < 6.0 * area(&least) + 1e-3, "{mu}: {} {}", area(&ours), area(&least));
    }
}

#[test]
fn patches_cut_in_pieces_are_those_cut_at_once() {
    for (name, whisker) in kinds().into_iter().step_by(3) {
        let mut whole = RodContacts::new(&whisker, 0.1, PI, 0.01).unwrap();
        let mut parts = whole.clone();
        whole.refine(0.03);
        let (mut all, mut pieces) = (0, 0);
        loop {
            let done = parts.refine_some(0.03, 7);
            (all, pieces) = (all + done, pieces + 1);
            if done < 7 {
                break;
            }
        }
        assert!(pieces > 5 && all <= 7 * pieces, "{name}: {pieces}");
        let patches = |contacts: &RodContacts| contacts.table(16, 0.03).patches();
        assert_eq!(patches(&whole), patches(&parts), "{name}");
        let slices = |contacts: &RodContacts| format!("{:?}", contacts.table(16, 0.03).slice(1.0, 0.2, 0.25));
        assert_eq!(slices(&whole), slices(&parts), "{name}");
        assert_eq!(parts.refine_some(0.03, 7), 0, "{name}");
    }
}

#[test]
fn a_whisker_that_makes_no_sense_is_refused() {
    let bad = [unit(|w| w.length = -1.0), unit(|w| w.tip_ratio = 0.0), unit(|w| w.curvature = 7.0)];
    for whisker in bad {
        assert!(RodContacts::new(&whisker, 0.0, PI, 0.0).is_err());
    }
}
