//! The tip of any straight whisker as estimators ask for it, against the integrated rod.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

#[path = "../../vibrissa/tests/data/random.rs"]
mod random;

use core::f64::consts::PI;
use random::Random;
use vibrissa_beam::beam::{Rod, Stretch, TipModel, TipReading, Whisker, largest_tip_moment, tip_chart, tip_curve};
use vibrissa_beam::plane::Vec2;

fn whiskers() -> Vec<(&'static str, Whisker)> {
    let paper = Whisker::default();
    let wire =
        |length, flexural_rigidity, tip_ratio| Stretch { length, flexural_rigidity, tip_ratio, ..Stretch::default() };
    vec![
        ("tapered to a third", Whisker { tip_ratio: 0.33, ..paper }),
        ("tapered to a twentieth", Whisker { tip_ratio: 0.05, ..paper }),
        ("on an elastic base", Whisker { base_stiffness: 0.02, ..paper }),
        ("of two wires", Whisker::of_stretches(&[wire(0.03, 3e-4, 1.0), wire(0.05, 6e-5, 0.4)]).unwrap()),
    ]
}

/// The rod under the model's dimensionless load: tip over length, slope, dimensionless moment.
fn bent(rod: &Rod, model: &TipModel, q: f64, beta: f64) -> (Vec2, f64, f64) {
    let length = model.whisker().length;
    let bend = rod.pushed(q * model.rigidity() / length.powi(2), length, beta).unwrap();
    (bend.contact * (1.0 / length), bend.phi_a, bend.moment * length / model.rigidity())
}

#[test]
fn the_chart_and_its_derivatives_are_those_of_the_rod() {
    let mut draw = Random(71);
    for (name, whisker) in whiskers() {
        let (model, rod) = (TipModel::new(&whisker).unwrap(), Rod::new(&whisker).unwrap());
        let mut worst = [0.0_f64; 2];
        let mut held = 0;
        for _ in 0..300 {
            let (q, beta) = (draw.between(-4.0, 4.0), draw.between(-PI, PI));
            let Some(chart) = model.chart(q, beta) else { continue };
            held += 1;
            let (place, slope, moment) = bent(&rod, &model, q, beta);
            let off =
                (chart.position - place).norm().max((chart.slope - slope).abs()).max((chart.moment - moment).abs());
            worst[0] = worst[0].max(off);
            let h = 1e-5;
            for (k, rate) in [chart.by_force, chart.by_tilt].into_iter().enumerate() {
                let (dq, dbeta) = if k == 0 { (h, 0.0) } else { (0.0, h) };
                let (more, less) = (bent(&rod, &model, q + dq, beta + dbeta), bent(&rod, &model, q - dq, beta - dbeta));
                let per = 0.5 / h;
                let by = [(more.0 - less.0).x, (more.0 - less.0).y, more.1 - less.1, more.2 - less.2].map(|d| d * per);
                let ours = [rate.position.x, rate.position.y, rate.slope, rate.moment];
                let size = by.iter().map(|d| d.abs()).fold(1.0, f64::max);
                worst[1] = by.iter().zip(ours).map(|(a, b)| (a - b).abs() / size).fold(worst[1], f64::max);
            }
        }
        println!("{name}: {held} loads, chart off by {:.1e}, derivatives by {:.1e}", worst[0], worst[1]);
        assert!(held > 100 && worst[0] < 2e-4 && worst[1] < 5e-3, "{name}: {held} {worst:?}");
    }
}

#[test]
fn small_loads_bend_the_tip_as_they_bend_a_uniform_whisker() {
    for (name, whisker) in whiskers() {
        let (model, rod) = (TipModel::new(&whisker).unwrap(), Rod::new(&whisker).unwrap());
        let q = 1e-3;
        let (place, ..) = bent(&rod, &model, q, 0.0);
        assert!((place.y / (q / 3.0) - 1.0).abs() < 1e-4, "{name}: {place:?}");
        assert!(!model.is_uniform());
    }
    let paper = TipModel::new(&Whisker::default()).unwrap();
    assert!(paper.is_uniform() && paper.rigidity().to_bits() == Whisker::default().flexural_rigidity.to_bits());
    assert_eq!(paper.chart(0.7, -0.2), tip_chart(0.7, -0.2));
    let scale = Whisker::default().flexural_rigidity / Whisker::default().length;
    assert_eq!(paper.curve(TipReading::Moment(1.3 * scale)).len(), tip_curve(1.3).len());
    assert!((paper.largest_moment(0.0) / (scale * largest_tip_moment(0.0)) - 1.0).abs() < 1e-12);
}

#[test]
fn every_equilibrium_of_a_curve_has_the_moment() {
    for (name, whisker) in whiskers() {
        let (model, rod) = (TipModel::new(&whisker).unwrap(), Rod::new(&whisker).unwrap());
        let largest = model.largest_moment(f64::INFINITY) * whisker.length / model.rigidity();
        for share in [0.01, 0.1, 0.4, 0.8] {
            let mu = share * largest;
            let pieces = model.curve(TipReading::Moment(mu * model.rigidity() / whisker.length));
            assert!(!pieces.is_empty(), "{name}: {share}");
            for piece in &pieces {
                assert!(piece.windows(2).all(|pair| pair[0].direction < pair[1].direction), "{name}: {share}");
                for e in piece {
                    let (place, slope, moment) = bent(&rod, &model, e.t * e.t, e.tilt());
                    assert!((moment / mu - 1.0).abs() < 2e-3, "{name}: {moment} for {mu}");
                    assert!(place.distance(Vec2::new(e.x, e.y)) < 2e-4 && (slope - e.slope).abs() < 2e-4, "{name}");
                }
                let longest = piece.windows(2).map(|p| (p[0].x - p[1].x).hypot(p[0].y - p[1].y)).fold(0.0, f64::max);
                assert!(longest < 0.04, "{name}: a gap of {longest}");
            }
        }
        let beyond = 1.001 * model.largest_moment(f64::INFINITY);
        assert!([beyond, -1.0, f64::NAN].into_iter().all(|m| model.curve(TipReading::Moment(m)).is_empty()));
    }
}

#[test]
fn curves_of_force_and_slope_have_them() {
    for (name, whisker) in whiskers().into_iter().chain([("the paper's", Whisker::default())]) {
        let (model, rod) = (TipModel::new(&whisker).unwrap(), Rod::new(&whisker).unwrap());
        let unit = model.rigidity() / whisker.length.powi(2);
        let mut kept = 0;
        for reading in [
            TipReading::Force(0.3 * unit),
            TipReading::Force(1.5 * unit),
            TipReading::Slope(0.2),
            TipReading::Slope(0.9),
        ] {
            let pieces = model.curve(reading);
            assert!(!pieces.is_empty(), "{name}: {reading:?}");
            for e in pieces.iter().flatten() {
                let (place, slope, _) = bent(&rod, &model, e.t * e.t, e.tilt());
                assert!(
                    place.distance(Vec2::new(e.x, e.y)) < 2e-4 && (slope - e.slope).abs() < 2e-4,
                    "{name}: {reading:?}"
                );
                match reading {
                    TipReading::Force(force) => assert!((e.t * e.t * unit / force - 1.0).abs() < 1e-9),
                    TipReading::Slope(at) => assert!((slope - at).abs() < 3e-4, "{name}: {slope} {at}"),
                    TipReading::Moment(_) => {}
                }
                kept += 1;
            }
        }
        assert!(kept > 300, "{name}: {kept}");
        let none = [0.0, -1.0, f64::NAN].into_iter().flat_map(|z| [TipReading::Force(z), TipReading::Slope(z)]);
        none.for_each(|reading| assert!(model.curve(reading).is_empty(), "{name}: {reading:?}"));
    }
}

#[test]
fn no_load_makes_more_than_the_largest_moment() {
    let mut draw = Random(72);
    for (name, whisker) in whiskers() {
        let model = TipModel::new(&whisker).unwrap();
        for steepest in [0.0, 0.5, f64::INFINITY] {
            let largest = model.largest_moment(steepest) * whisker.length / model.rigidity();
            let mut seen = 0.0_f64;
            for _ in 0..20_000 {
                let beta = draw.between(-1.0, 1.0) * steepest.min(1.45);
                seen = seen.max(model.chart(draw.between(0.0, 20.0), beta).map_or(0.0, |chart| chart.moment));
            }
            println!("{name}, tilts to {steepest}: {largest:.4}, seen {seen:.4}");
            assert!(seen <= largest && seen > 0.97 * largest, "{name}: {seen} of {largest}");
        }
    }
}

#[test]
fn a_curved_whisker_is_refused_by_name() {
    let error = TipModel::new(&Whisker { curvature: 3.0, ..Whisker::default() }).unwrap_err().to_string();
    assert!(error.contains("curvature") && error.contains('3'), "{error}");
    assert!(TipModel::new(&Whisker { tip_ratio: 0.0, ..Whisker::default() }).is_err());
    assert!(TipModel::new(&Whisker { base_stiffness: -1.0, ..Whisker::default() }).is_err());
    assert!(TipModel::new(&Whisker { length: f64::NAN, ..Whisker::default() }).is_err());
}
