//! Temporal filtering against a peg whose place is known.

#![allow(clippy::unwrap_used, clippy::float_cmp, reason = "a test that cannot go on must fail")]

use vibrissa::beam::{Load, Whisker, point_mode};
use vibrissa::io::log::from_csv;
use vibrissa::plane::{Pose2, Vec2};
use vibrissa::tasks::temporal_filter::{FilteredContact, TemporalFilterOptions, temporal_filter};
use vibrissa::world::Robot;

/// The columns of a row that feels this force, slope, arc length and moment.
type ColumnsOf = fn([f64; 4]) -> String;

/// The peg, odometry frame (m).
const PEG: Vec2 = Vec2 { x: 0.05, y: 0.0 };

/// The base goes past the peg towards -y; the columns of the log are made of force, slope, arc length and moment.
fn felt(header: &str, columns: ColumnsOf, readings: usize) -> Vec<FilteredContact> {
    let mut text = format!("t,x,y,theta,{header}\n");
    for k in 0..40 {
        let base = Pose2::new(0.0, 0.002 - 0.5e-3 * f64::from(k), 0.0);
        let peg = base.inverse_transform_point(PEG);
        let bend = if peg.y > 0.0 {
            point_mode(&Whisker::default(), peg, Load::Normal).unwrap().into_iter().next()
        } else {
            None
        };
        let values = bend.map_or([0.0; 4], |bend| [bend.force, bend.phi_a, bend.s_a, bend.moment]);
        text += &format!("{},{},{},{},{}\n", f64::from(k) * 0.01, base.x, base.y, base.theta, columns(values));
    }
    let log = from_csv(&text, "log.csv").unwrap();
    temporal_filter(&log, &Robot::default(), &TemporalFilterOptions { readings, ..TemporalFilterOptions::default() })
        .unwrap()
}

#[test]
fn several_readings_of_any_sensor_leave_less_and_keep_the_peg() {
    let kinds: [(&str, ColumnsOf); 4] = [
        ("force", |[force, ..]| force.to_string()),
        ("slope", |[_, slope, ..]| slope.to_string()),
        (
            "strip_lo,strip_hi",
            |[_, _, s, _]| {
                if s > 0.0 { format!("{},{}", s - 2e-3, s + 2e-3) } else { "0,0".to_owned() }
            },
        ),
        ("moment", |[.., moment]| moment.to_string()),
    ];
    for (header, columns) in kinds {
        let (found, single) = (felt(header, columns, 3), felt(header, columns, 1));
        assert!(found.len() >= 4, "{header}: {}", found.len());
        for one in &found {
            let peg = one.odom_from_whisker.inverse_transform_point(PEG);
            assert!(one.extent[0].contains(peg.x) && one.extent[1].contains(peg.y), "{header} at {}: {one:?}", one.t);
        }
        // The same rows, with and without the readings before them.
        let (mut three, mut alone) = (0.0, 0.0);
        for one in found.iter().filter(|one| one.readings == 3) {
            three += one.area;
            alone += single.iter().find(|other| other.t == one.t).unwrap().area;
        }
        assert!(three > 0.0 && three < 0.8 * alone, "{header}: {three} of {alone} m²");
    }
}

#[test]
fn a_log_without_readings_is_refused() {
    let log = from_csv("t,x,y,theta,ax\n0,0,0,0,1\n0.1,0,0,0,1\n", "log.csv").unwrap();
    let error = temporal_filter(&log, &Robot::default(), &TemporalFilterOptions::default()).unwrap_err();
    assert!(error.to_string().contains("strip_lo"), "{error}");
}
