//! Moments that no shape of a rod has are told at once; none that a shape has is lost by it.

use vibrissa_beam::beam::{Load, Whisker, force_mode, moment_mode, point_mode};
use vibrissa_beam::plane::Vec2;

/// Uniform random numbers (splitmix64).
struct Random(u64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        low + (high - low) * ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

#[test]
fn what_a_strong_force_makes_is_found_again() {
    let mut random = Random(5);
    let mut found = 0;
    for _ in 0..60 {
        let (length, flexural_rigidity) = (random.between(0.02, 0.2), 10_f64.powf(random.between(-6.0, -2.0)));
        let base_stiffness = flexural_rigidity / length * 10_f64.powf(random.between(-1.0, 2.0));
        let tip_ratio = random.between(0.05, 1.0);
        let whisker = Whisker { length, flexural_rigidity, tip_ratio, base_stiffness, ..Whisker::default() };
        let s_a = length * random.between(0.2, 1.0);
        let scale = flexural_rigidity / (s_a * s_a);
        // Up to where the largest moments of the first mode are.
        let force = scale * random.between(0.1, 12.0) * if random.between(0.0, 1.0) < 0.5 { -1.0 } else { 1.0 };
        for load in [Load::Normal, Load::Tilted(random.between(-0.8, 0.8))] {
            for bend in force_mode(&whisker, force, s_a, load).unwrap() {
                let again = moment_mode(&whisker, bend.moment, s_a, load).unwrap();
                let near = again.iter().any(|other| (other.force / force - 1.0).abs() < 1e-6);
                assert!(near, "{whisker:?} {s_a} {load:?}: {force} N, {} N m", bend.moment);
                found += 1;
            }
        }
    }
    assert!(found > 40, "{found}");
}

#[test]
fn the_readings_of_another_whisker_have_no_shape() {
    // Ten metres of next to nothing, a base that hardly holds: what a usual whisker reads is a billion times beyond them.
    let thin = Whisker { length: 10.0, flexural_rigidity: 1e-12, tip_ratio: 1e-3, ..Whisker::default() };
    let soft = Whisker { base_stiffness: 1e-9, tip_ratio: 0.02, curvature: 20.0, ..Whisker::default() };
    for (whisker, share) in [(thin, 1.0), (thin, 0.1), (soft, 1.0), (soft, 0.5)] {
        for load in [Load::Normal, Load::Vertical, Load::Tilted(0.4)] {
            assert!(moment_mode(&whisker, 1e-3, share * whisker.length, load).unwrap().is_empty(), "{load:?}");
        }
    }
}

#[test]
fn a_base_that_hardly_holds_is_found_from_its_contact_as_far_as_half_a_turn() {
    let mut random = Random(9);
    for _ in 0..20 {
        let rigidity = 2.8886e-4;
        let base_stiffness = rigidity / 0.075 * 10_f64.powf(random.between(-1.5, 0.0));
        let whisker = Whisker { base_stiffness, tip_ratio: random.between(0.3, 1.0), ..Whisker::default() };
        let s_a = random.between(0.03, 0.075);
        let force = base_stiffness / s_a * random.between(0.1, 1.5);
        let bends = force_mode(&whisker, force, s_a, Load::Normal).unwrap();
        let Some(bend) = bends.first() else { continue };
        let contact = Vec2::new(bend.contact.x, bend.contact.y);
        let again = point_mode(&whisker, contact, Load::Normal).unwrap();
        let near = again.iter().any(|other| (other.moment / bend.moment - 1.0).abs() < 1e-6);
        assert!(near, "{whisker:?} {s_a} {force}: {} of {}", again.len(), bend.moment);
    }
}
