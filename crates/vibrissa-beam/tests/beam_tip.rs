//! Tip mode, strain and the small-angle model against the other modes, brute force and the paper's own table.

#![allow(clippy::float_cmp, clippy::unwrap_used)]

use vibrissa_beam::beam::elastica::bend;
use vibrissa_beam::beam::{Load, SmallAngle, Whisker, force_mode, tip_mode};
use vibrissa_beam::plane::Vec2;

#[allow(dead_code)]
#[path = "../../vibrissa/tests/data/random.rs"]
mod random;
use random::Random;

const EI: f64 = 2.8886e-4;

#[test]
fn tip_mode_finds_the_force_and_its_direction() {
    let mut random = Random(8);
    let (mut found, mut several, mut lost) = (0, 0, Vec::new());
    for i in 0..60 {
        let mut whisker = Whisker::default();
        if i % 2 == 1 {
            whisker.tip_ratio = 0.3 + 0.7 * random.unit();
            whisker.curvature = random.signed(6.0);
            whisker.base_stiffness = 0.2;
        }
        let taper = whisker.tip_ratio.powi(3);
        let force = random.signed(4.0) * taper * EI / (0.075 * 0.075);
        let beta = random.signed(1.2);
        let Some(b) = force_mode(&whisker, force, 0.075, Load::Tilted(beta)).unwrap().pop() else { continue };
        let all = tip_mode(&whisker, b.contact).unwrap();
        found += 1;
        several += usize::from(all.len() > 1);
        if !all.iter().any(|a| a.force_vector().distance(b.force_vector()) < 1e-6 * force.abs()) {
            lost.push(format!("{whisker:?} {force} {beta} {:?}", b.contact));
        }
        for a in &all {
            assert!(a.contact.distance(b.contact) < 1e-10 && a.s_a == 0.075, "{a:?} {:?}", b.contact);
            assert!((a.moment - a.contact.cross(a.force_vector())).abs() < 1e-9 * a.force.abs() * 0.075);
        }
        assert!(all.windows(2).all(|w| w[0].energy() <= w[1].energy()));
    }
    println!("{found} tips, {several} with several shapes, {} lost", lost.len());
    lost.iter().for_each(|l| println!("{l}"));
    assert!(found > 50 && lost.is_empty());
}

#[test]
fn the_tips_force_is_the_gradient_of_the_energy() {
    let whisker = Whisker { tip_ratio: 0.5, curvature: 3.0, base_stiffness: 0.3, ..Whisker::default() };
    for tip in [Vec2::new(0.06, 0.03), Vec2::new(0.05, -0.03), Vec2::new(0.065, 0.02)] {
        let energy = |p: Vec2| tip_mode(&whisker, p).unwrap().first().map(|b| b.energy()).unwrap();
        let h = 1e-6;
        let dx = (energy(tip + Vec2::new(h, 0.0)) - energy(tip - Vec2::new(h, 0.0))) / (2.0 * h);
        let dy = (energy(tip + Vec2::new(0.0, h)) - energy(tip - Vec2::new(0.0, h))) / (2.0 * h);
        let force = tip_mode(&whisker, tip).unwrap()[0].force_vector();
        assert!(force.distance(Vec2::new(dx, dy)) < 1e-5 * force.norm(), "{force:?} {dx} {dy}");
    }
}

#[test]
fn what_no_tip_can_reach() {
    let whisker = Whisker::default();
    assert!(tip_mode(&whisker, Vec2::new(0.076, 0.0)).unwrap().is_empty());
    assert!(tip_mode(&whisker, Vec2::ZERO).unwrap_err().is_usage());
    assert!(tip_mode(&whisker, Vec2::new(f64::NAN, 0.0)).unwrap_err().is_usage());
}

#[test]
fn strain_is_largest_where_a_fine_scan_says() {
    let tapered = Whisker { tip_ratio: 0.2, curvature: -4.0, ..Whisker::default() };
    let bends = [
        bend(EI, 0.3, 0.06, 0.0).unwrap(),
        bend(EI, -0.2, 0.06, -1.2).unwrap(),
        force_mode(&tapered, 0.01, 0.07, Load::Normal).unwrap().remove(0),
    ];
    for (b, (narrowing, rest)) in bends.iter().zip([(0.0, 0.0), (0.0, 0.0), (0.8 / 0.075, -4.0)]) {
        let largest = b.largest_strain(0.58e-3);
        let points = b.shape_points(b.s_a, 20_001);
        let strain = |(s, p): &(f64, vibrissa_beam::beam::ShapePoint)| {
            (p.curvature - rest).abs() * 0.29e-3 * (1.0 - narrowing * s)
        };
        let scanned = points[..20_000].iter().map(strain).fold(0.0, f64::max);
        assert!((largest.strain / scanned - 1.0).abs() < 1e-6, "{largest:?} {scanned}");
    }
    // Under a normal load the base is bent the most, up to a right angle.
    let b = &bend(EI, 0.1, 0.06, 0.0).unwrap();
    assert!(b.largest_strain(0.58e-3).s == 0.0 && (b.largest_strain(2.0).strain * EI / b.moment - 1.0).abs() < 1e-12);
}

#[test]
fn the_small_angle_model_is_the_limit_and_no_more() {
    for q in [1e-6, 1e-4, -1e-3] {
        let force = 2.0 * EI * q / (0.06 * 0.06);
        let (a, b) = (SmallAngle::from_force(EI, force, 0.06), bend(EI, force, 0.06, 0.0).unwrap());
        for (small, exact) in [
            (a.phi_a(), b.phi_a),
            (a.contact().y, b.contact.y),
            (a.moment(), b.moment),
            (a.energy(), b.energy()),
            (a.point_at(0.03).y, b.point_at(0.03).position.y),
            (a.point_at(0.075).y, b.point_at(0.075).position.y),
        ] {
            assert!((small / exact - 1.0).abs() < 2.0 * q * q + 1e-12, "{q} {small} {exact}");
        }
        assert!((SmallAngle::from_point(EI, a.contact()).force / force - 1.0).abs() < 1e-14);
        assert!((SmallAngle::from_moment(EI, a.moment(), 0.06).force / force - 1.0).abs() < 1e-14);
        let both = SmallAngle::from_moment_and_deflection(EI, a.moment(), a.contact().y).unwrap();
        assert!((both.s_a - 0.06).abs() < 1e-15);
    }
    let strong = bend(EI, 0.2, 0.06, 0.0).unwrap();
    assert!((SmallAngle::from_force(EI, 0.2, 0.06).contact().y / strong.contact.y - 1.0).abs() > 0.15);
    assert!(SmallAngle::from_moment_and_deflection(EI, 1e-3, -1e-3).is_none());
    assert!(SmallAngle::from_moment_and_deflection(EI, 0.0, 1e-3).is_none());
}
