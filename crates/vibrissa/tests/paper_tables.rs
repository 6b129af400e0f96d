//! Numbers printed in the paper, computed here.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

use vibrissa::beam::{SmallAngle, Whisker};

/// The column "SOTA" of the table of contact points: the small-angle formula, to the digit, from the column of moments.
#[test]
fn the_earlier_methods_contact_distances() {
    let whisker = Whisker::default();
    for (moment, distance) in [(0.19, 67.5), (0.20, 65.8), (0.28, 55.6), (0.42, 45.4), (0.63, 37.1)] {
        let bent = SmallAngle::from_moment_and_deflection(whisker.flexural_rigidity, 1e-3 * moment, 1e-3).unwrap();
        let shown = (1e4 * bent.s_a).round() / 10.0;
        assert!((shown - distance).abs() < 1e-9, "{moment} mN m: {shown} mm, printed {distance} mm");
    }
}
