//! Each error of readings, stamps and odometry against what it is declared to be.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

use vibrissa::flow::pose::StampedPose;
use vibrissa::io::log::to_csv;
use vibrissa::plane::{Pose2, Vec2};
use vibrissa::sensing::SensingChain;
use vibrissa::sim::recorder::{
    Columns, Disturbances, Magnetometer, NoiseLaw, OdometryErrors, Recorder, Recording, STRIP_CELL, SerialLayout, Slip,
    Stamps, TrueErrors, serial_text,
};
use vibrissa::sim::{Sweep, SweepNoise, simulate_tip_sweep};
use vibrissa::tasks::demo;
use vibrissa::world::{MomentNoise, ReadingNoise, Robot};

const ROWS: usize = 20_000;

/// A robot that drives straight at 1 mm a row, with moments that rise and fall between 0 and 2 mN m, ten times.
fn sweep() -> Sweep {
    let t = |k: usize| k as f64 / 300.0;
    let pose = |k: usize| StampedPose { t: t(k), map_from_robot: Pose2::new(0.3 + 1e-3 * k as f64, 0.2, 0.0) };
    let triangle = |k: usize| 2e-3 * (1.0 - ((k % 2000) as f64 / 1000.0 - 1.0).abs());
    let mut sweep = demo::sweep(1).unwrap();
    sweep.truth = (0..ROWS).map(pose).collect();
    sweep.exact_moments = (0..ROWS).map(|k| vec![triangle(k)]).collect();
    sweep
}

/// Exact but for the given errors.
fn exact() -> Recorder {
    Recorder { noise: SweepNoise { seed: 5, ..SweepNoise::none() }, ..Recorder::default() }
}

fn record(recorder: &Recorder, sweep: &Sweep) -> Recording {
    recorder.record(&Robot::default(), sweep).unwrap()
}

/// Reading minus truth for each row.
fn errors(disturbances: Disturbances) -> Vec<f64> {
    let sweep = sweep();
    let recording = record(&Recorder { disturbances, ..exact() }, &sweep);
    let pairs = recording.log.rows.iter().zip(&sweep.exact_moments);
    pairs.map(|(row, exact)| row.readings[0] - exact[0]).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn deviation(values: &[f64]) -> f64 {
    let centre = mean(values);
    (values.iter().map(|v| (v - centre).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

#[test]
fn without_disturbances_the_sweeps_own_log_comes_out() {
    for seed in [1, 7] {
        let sweep = demo::sweep(seed).unwrap();
        let recorder = Recorder { noise: SweepNoise::seeded(seed), ..Recorder::default() };
        assert_eq!(record(&recorder, &sweep).log, sweep.log);
    }
}

#[test]
fn gaussian_noise_has_its_deviation_and_shape() {
    let errors = errors(Disturbances { gaussian_absolute: 1e-5, ..Disturbances::default() });
    assert!(mean(&errors).abs() < 4.0 * 1e-5 / (ROWS as f64).sqrt(), "{}", mean(&errors));
    assert!((deviation(&errors) / 1e-5 - 1.0).abs() < 0.02, "{}", deviation(&errors));
    let within = |size: f64| errors.iter().filter(|e| e.abs() < size).count() as f64 / ROWS as f64;
    assert!((within(1e-5) - 0.6827).abs() < 0.015 && (within(2e-5) - 0.9545).abs() < 0.008, "{}", within(1e-5));
    let uncorrelated = mean(&errors.windows(2).map(|w| w[0] * w[1]).collect::<Vec<_>>());
    assert!(uncorrelated.abs() < 4.0 * 1e-10 / (ROWS as f64).sqrt(), "{uncorrelated}");
}

#[test]
fn relative_gaussian_noise_grows_with_the_reading() {
    let errors = errors(Disturbances { gaussian_relative: 0.02, ..Disturbances::default() });
    let sweep = sweep();
    let ratios: Vec<f64> =
        errors.iter().zip(&sweep.exact_moments).filter(|(_, m)| m[0] > 1e-6).map(|(e, m)| e / m[0]).collect();
    assert!((deviation(&ratios) / 0.02 - 1.0).abs() < 0.02, "{}", deviation(&ratios));
}

#[test]
fn gain_and_offset_are_constant_and_bounded() {
    let mut gains = Vec::new();
    for seed in 0..40 {
        let disturbances = Disturbances { gain_error: 0.1, offset: 1e-4, ..Disturbances::default() };
        let noise = SweepNoise { seed, ..SweepNoise::none() };
        let log = record(&Recorder { noise, disturbances, ..exact() }, &sweep()).log;
        let (zero, top) = (log.rows[0].readings[0], log.rows[1000].readings[0]);
        let gain = (top - zero) / 2e-3;
        assert!((0.9..=1.1).contains(&gain) && zero.abs() <= 1e-4, "{gain}, {zero}");
        assert!((log.rows[500].readings[0] - zero - gain * 1e-3).abs() < 1e-15);
        gains.push(gain);
    }
    assert!(deviation(&gains) > 0.04 && mean(&gains) > 0.97 && mean(&gains) < 1.03, "uniform over its range");
}

#[test]
fn drift_is_a_straight_line_in_time() {
    let errors = errors(Disturbances { drift: 1e-5, ..Disturbances::default() });
    let rate = errors[ROWS - 1] / ((ROWS - 1) as f64 / 300.0);
    assert!(rate.abs() <= 1e-5 && rate.abs() > 1e-8, "{rate}");
    for (k, error) in errors.iter().enumerate() {
        assert!((error - rate * k as f64 / 300.0).abs() < 1e-15);
    }
}

#[test]
fn hysteresis_lags_by_half_its_width_both_ways() {
    let errors = errors(Disturbances { hysteresis: 2e-4, ..Disturbances::default() });
    // Well inside the rising and the falling flanks; each cycle of 2000 rows turns at 1000.
    for cycle in 1..10 {
        for k in 300..900 {
            assert!((errors[2000 * cycle + k] + 1e-4).abs() < 1e-15, "rising: {}", errors[2000 * cycle + k]);
            assert!((errors[2000 * cycle + 1000 + k] - 1e-4).abs() < 1e-15, "falling");
        }
    }
}

#[test]
fn outliers_come_at_their_share_and_size() {
    let errors = errors(Disturbances { outlier_share: 0.03, outlier_size: 1e-3, ..Disturbances::default() });
    let off: Vec<f64> = errors.into_iter().filter(|e| e.abs() > 1e-15).collect();
    let share = off.len() as f64 / ROWS as f64;
    assert!((share - 0.03).abs() < 0.005, "{share}");
    assert!(off.iter().all(|e| e.abs() <= 1e-3));
    assert!((deviation(&off) / (1e-3 / 3f64.sqrt()) - 1.0).abs() < 0.1, "uniform");
}

#[test]
fn bounded_noise_stays_in_its_bound() {
    let sweep = sweep();
    let noise = SweepNoise::seeded(3);
    let log = record(&Recorder { noise, ..Recorder::default() }, &sweep).log;
    for (row, h) in log.rows.iter().zip(&sweep.exact_moments) {
        let z = row.readings[0];
        assert!((h[0] - z).abs() <= 0.05 * z.abs() + 2e-5 + 1e-15, "{z} for {}", h[0]);
    }
}

#[test]
fn rows_are_dropped_and_delayed_at_their_shares() {
    let sweep = sweep();
    let stamps = Stamps { dropped_share: 0.1, late_share: 0.2, late_by: 2e-3 };
    let recording = record(&Recorder { stamps, ..exact() }, &sweep);
    let kept = recording.rows.len() as f64 / ROWS as f64;
    assert!((kept - 0.9).abs() < 0.01, "{kept}");
    assert_eq!(recording.rows[0], 0);
    let delays: Vec<f64> =
        recording.log.rows.iter().zip(&recording.rows).map(|(row, &k)| row.t - sweep.truth[k].t).collect();
    let late = delays.iter().filter(|&&d| d > 0.0).count() as f64 / delays.len() as f64;
    assert!((late - 0.2).abs() < 0.015, "{late}");
    assert!(delays.iter().all(|d| (0.0..=2e-3).contains(d)));
    for (row, &k) in recording.log.rows.iter().zip(&recording.rows) {
        assert!((row.readings[0] - sweep.exact_moments[k][0]).abs() < 1e-18, "the reading is its own row's");
    }
    let long = Stamps { late_share: 0.5, late_by: 0.05, ..Stamps::default() };
    let log = record(&Recorder { stamps: long, ..exact() }, &sweep).log;
    assert!(log.rows.windows(2).all(|w| w[1].t > w[0].t), "stamps increase whatever the delay");
    assert_eq!(log.rows.len(), ROWS);
}

#[test]
fn the_wheels_err_by_scale_drift_and_slips() {
    let sweep = sweep();
    let end =
        |odometry: OdometryErrors| record(&Recorder { odometry, ..exact() }, &sweep).log.rows[ROWS - 1].odom_from_robot;
    let way = 1e-3 * (ROWS - 1) as f64;
    let straight = end(OdometryErrors::default());
    assert!((straight.x - way).abs() < 1e-9 && straight.y.abs() < 1e-12);
    let scaled = end(OdometryErrors { scale_error: 0.05, ..OdometryErrors::default() });
    let scale = scaled.x / way;
    assert!((0.95..=1.05).contains(&scale) && (scale - 1.0).abs() > 1e-4 && scaled.y.abs() < 1e-9, "{scale}");
    // A constant turn per way is a circle: x = sin(k s) / k.
    let turned = end(OdometryErrors { heading_drift: 0.1, ..OdometryErrors::default() });
    let k = turned.theta / way;
    assert!(k.abs() <= 0.1 && k.abs() > 1e-3, "{k}");
    assert!((turned.x - (k * way).sin() / k).abs() < 1e-3 * way, "{turned:?}");
    // 300 rows slip from t = 10 s on: 300 mm count 1.5 times.
    let slip = Slip { t: 10.0, duration: 1.0, share: 0.5 };
    let slipped = end(OdometryErrors { slips: vec![slip], ..OdometryErrors::default() });
    assert!((slipped.x - way - 0.15).abs() < 1e-9, "{}", slipped.x - way);
}

#[test]
fn one_error_more_leaves_the_others_as_they_were() {
    let sweep = sweep();
    let gaussian = Disturbances { gaussian_absolute: 1e-5, ..Disturbances::default() };
    let noise = SweepNoise { seed: 5, ..SweepNoise::default() };
    let base = record(&Recorder { noise, disturbances: gaussian, ..Recorder::default() }, &sweep);
    let stamps = Stamps { dropped_share: 0.2, ..Stamps::default() };
    let more = record(&Recorder { noise, disturbances: gaussian, stamps, ..Recorder::default() }, &sweep);
    for (row, &k) in more.log.rows.iter().zip(&more.rows) {
        assert!((row.readings[0] - base.log.rows[k].readings[0]).abs() < 1e-18);
    }
}

#[test]
fn flux_and_counts_are_what_the_chip_makes_of_the_moment() {
    let sweep = sweep();
    let columns = vec![Columns::Flux, Columns::Counts, Columns::Moment];
    let recording = record(&Recorder { columns, ..exact() }, &sweep);
    let names: Vec<String> = recording.log.channels.iter().map(|c| c.column()).collect();
    assert_eq!(names, ["bx", "by", "bz", "ax", "ay", "az", "moment"]);
    let chain = SensingChain::default();
    for (row, exact) in recording.log.rows.iter().zip(&sweep.exact_moments).step_by(97) {
        let field = chain.flux(exact[0]);
        for ((per_count, field), read) in chain.chip.per_count().iter().zip(field).zip(row.readings.windows(4)) {
            assert!((read[0] - field).abs() <= *per_count, "{} and {field}", read[0]);
            assert!((read[0] / per_count - read[3]).abs() < 1e-6, "counts times sensitivity");
        }
    }
    let noisy = Magnetometer { flux_noise: 2e-6, ..Magnetometer::default() };
    let loud = record(&Recorder { magnetometer: noisy, columns: vec![Columns::Flux], ..exact() }, &sweep);
    let noise: Vec<f64> =
        loud.log.rows.iter().zip(&sweep.exact_moments).map(|(row, m)| row.readings[1] - chain.flux(m[0])[1]).collect();
    // Quantization adds its own twelfth of a square count.
    let expected = (4e-12 + chain.chip.per_count()[1].powi(2) / 12.0).sqrt();
    assert!((deviation(&noise) / expected - 1.0).abs() < 0.03, "{} and {expected}", deviation(&noise));
}

#[test]
fn force_slope_and_strip_are_those_of_the_bent_whisker() {
    let (map, mut robot) = (demo::arena().unwrap(), Robot::default());
    let sweep = simulate_tip_sweep(&map, &robot, &demo::path().unwrap(), &SweepNoise::none()).unwrap();
    let columns = vec![Columns::Force, Columns::Slope, Columns::Strip, Columns::Moment];
    let recorder = Recorder { columns, ..exact() };
    let noisy = recorder.record(&robot, &sweep).unwrap().log;
    let names: Vec<String> = noisy.channels.iter().map(|c| c.column()).collect();
    assert_eq!(names, ["force", "slope", "strip_lo", "strip_hi", "moment"]);
    let none = ReadingNoise { relative: 0.0, absolute: 0.0 };
    (robot.whiskers[0].force_noise, robot.whiskers[0].slope_noise) = (none, none);
    let log = recorder.record(&robot, &sweep).unwrap().log;
    let whisker = Robot::default().whiskers[0].clone();
    let (mut touching, mut farthest) = (0, [0.0_f64; 2]);
    for (index, (row, other)) in log.rows.iter().zip(&noisy.rows).enumerate() {
        let [force, slope, low, high, moment] = row.readings[..] else { panic!("five readings") };
        for (k, noise) in [(0, whisker.force_noise), (1, whisker.slope_noise)] {
            let (z, h) = (other.readings[k], row.readings[k]);
            let bound = noise.relative * z.abs() + noise.absolute;
            assert!((h - z).abs() <= bound * (1.0 + 1e-9), "{z} is not within the bound around {h}");
            farthest[k] = farthest[k].max((h - z).abs() / bound);
        }
        let Some(touch) = sweep.contacts.iter().find(|touch| touch.row == index) else {
            assert!([force, slope, low, high].iter().all(|reading| reading.abs() <= 0.0));
            continue;
        };
        touching += 1;
        // The elastica keeps M²/2EI + F·t along its length, and its tip carries no moment.
        let base = sweep.truth[index].map_from_robot.compose(whisker.robot_from_whisker);
        let seen = touch.force.rotated(-base.theta);
        let along = |angle: f64| seen.dot(Vec2::from_angle(angle));
        let energy = moment * moment / (2.0 * whisker.beam.flexural_rigidity);
        assert!((along(slope) - along(0.0) - energy).abs() < 1e-6 * energy.max(1e-6), "row {index}");
        assert!((force.abs() - touch.force.norm()).abs() < 1e-12 && (force > 0.0) == (moment > 0.0));
        assert!(low <= whisker.beam.length && whisker.beam.length < high && (high - low - STRIP_CELL).abs() < 1e-12);
    }
    assert!(touching > 100 && farthest.iter().all(|share| *share > 0.9), "{touching} {farthest:?}");
}

#[test]
fn a_compass_has_its_noise_and_is_written_and_read_back() {
    let sweep = sweep();
    let recorder =
        Recorder { heading_noise: Some(0.02), stamps: Stamps { dropped_share: 0.1, ..Stamps::default() }, ..exact() };
    let log = record(&recorder, &sweep).log;
    let errors: Vec<f64> = log.rows.iter().map(|row| row.heading.unwrap()).collect();
    assert!(mean(&errors).abs() < 1e-3 && (deviation(&errors) / 0.02 - 1.0).abs() < 0.03, "{}", deviation(&errors));
    let again = vibrissa::io::log::from_csv(&to_csv(&log), "log.csv").unwrap();
    assert_eq!(again.rows.len(), log.rows.len());
    assert!(again.rows.iter().zip(&log.rows).all(|(a, b)| a.heading == b.heading && a.readings == b.readings));
}

#[test]
fn readings_beyond_the_chip_are_warned_about() {
    let mut strong = sweep();
    strong.exact_moments.iter_mut().for_each(|m| m[0] *= 20.0);
    let recording = record(&Recorder { columns: vec![Columns::Counts], ..exact() }, &strong);
    assert!(recording.log.warnings.is_empty(), "the default chip takes any tilt: {:?}", recording.log.warnings);
    let near = SensingChain { chip_offset: [-0.0065, 0.0, 0.0], ..SensingChain::default() };
    let magnetometer = Magnetometer { chain: near, flux_noise: 0.0 };
    let recording = record(&Recorder { magnetometer, columns: vec![Columns::Counts], ..exact() }, &sweep());
    assert!(recording.log.warnings[0].contains("20000 readings of w0 are beyond"), "{:?}", recording.log.warnings);
}

#[test]
fn the_serial_line_says_microtesla_without_stamps() {
    let recording = record(&exact(), &sweep());
    let text = serial_text(&recording, SerialLayout::Single).unwrap();
    let lines: Vec<&str> = text.split("\r\n").collect();
    assert_eq!(lines.len(), ROWS + 1, "each line ends");
    for (line, flux) in lines.iter().zip(&recording.flux).step_by(501) {
        let values: Vec<f64> = line.split(',').map(|v| v.parse().unwrap()).collect();
        for k in 0..3 {
            assert!((values[k] * 1e-6 - flux[0][k]).abs() < 0.5001e-8, "{line}");
        }
    }
    assert!(serial_text(&recording, SerialLayout::Interleaved).unwrap_err().is_usage(), "one whisker is not two");
}

#[test]
fn options_out_of_range_are_refused() {
    let sweep = sweep();
    let bad = |disturbances| Recorder { disturbances, ..exact() };
    let nan = f64::NAN;
    for recorder in [
        bad(Disturbances { hysteresis: -1.0, ..Disturbances::default() }),
        bad(Disturbances { gain_error: 1.0, ..Disturbances::default() }),
        bad(Disturbances { outlier_share: nan, ..Disturbances::default() }),
        bad(Disturbances { drift: f64::INFINITY, ..Disturbances::default() }),
        Recorder { stamps: Stamps { dropped_share: 1.0, ..Stamps::default() }, ..exact() },
        Recorder { odometry: OdometryErrors { heading_drift: nan, ..OdometryErrors::default() }, ..exact() },
        Recorder {
            odometry: OdometryErrors {
                slips: vec![Slip { t: 0.0, duration: 1.0, share: -1.0 }],
                ..OdometryErrors::default()
            },
            ..exact()
        },
        Recorder { magnetometer: Magnetometer { flux_noise: -1.0, ..Magnetometer::default() }, ..exact() },
    ] {
        assert!(recorder.record(&Robot::default(), &sweep).unwrap_err().is_usage(), "{recorder:?}");
    }
}

/// The errors of a law over their bound, of readings that are bounded by 5 % and 20 uN m.
fn shares(law: NoiseLaw) -> Vec<f64> {
    let sweep = sweep();
    let recording = record(&Recorder { law, noise: SweepNoise::seeded(5), ..Recorder::default() }, &sweep);
    let noise = MomentNoise::default();
    let share = |(row, exact): (&vibrissa::flow::sensor_log::LogRow, &Vec<f64>)| {
        let z = row.readings[0];
        (z - exact[0]) / (noise.moment_relative * z.abs() + noise.moment_absolute)
    };
    recording.log.rows.iter().zip(&sweep.exact_moments).map(share).collect()
}

#[test]
fn every_law_keeps_within_the_declared_bound() {
    for word in NoiseLaw::WORDS {
        let shares = shares(NoiseLaw::from_word(word).unwrap());
        let largest = shares.iter().fold(0.0_f64, |most, share| most.max(share.abs()));
        assert!(largest <= 1.0, "{word}: {largest}");
        assert_eq!(largest < 0.05, word == "none", "{word}: {largest}");
    }
    assert_eq!(NoiseLaw::from_word("white"), None);
}

#[test]
fn random_laws_have_the_deviation_and_the_correlation_that_they_tell() {
    let laws = [NoiseLaw::Uniform, NoiseLaw::TwoPoint, NoiseLaw::Autoregressive { time_constant: 0.1 }];
    for law in laws {
        let shares = shares(law);
        let (told, _) = law.moments(0.0).unwrap();
        assert!((deviation(&shares) / told - 1.0).abs() < 0.05, "{law:?}: {} for {told}", deviation(&shares));
        for rows in [3_usize, 30, 60] {
            let apart: Vec<f64> = shares.iter().zip(&shares[rows..]).map(|(a, b)| a * b).collect();
            let (found, told) = (mean(&apart) / told.powi(2), law.moments(rows as f64 / 300.0).unwrap().1);
            assert!((found - told).abs() < 0.08, "{law:?}, {rows} rows apart: {found} for {told}");
        }
    }
    assert_eq!(NoiseLaw::Step.moments(0.0), None);
}

#[test]
fn laws_over_time_change_where_they_say() {
    let step = shares(NoiseLaw::Step);
    assert!(step[ROWS / 4] > 0.5 && step[3 * ROWS / 4] < -0.5);
    let drift = shares(NoiseLaw::Drift);
    assert!(drift[1] < -0.9 && drift[ROWS - 2] > 0.9 && drift[ROWS / 2].abs() < 0.01);
    // The moment rises for a thousand rows and falls for a thousand.
    let loops = shares(NoiseLaw::Hysteresis);
    assert!(loops[500] > 0.5 && loops[1500] < -0.5 && loops[2500] > 0.5);
    let dead = shares(NoiseLaw::DeadZone);
    assert!(dead.iter().all(|share| *share <= 0.0) && dead[5] < -0.4);
    assert!(shares(NoiseLaw::Offset).iter().all(|share| (0.1..=1.0).contains(share)));
}

#[test]
fn true_errors_are_the_true_values_less_the_declared_ones() {
    let sweep = sweep();
    let readings = |truth: TrueErrors| -> Vec<f64> {
        record(&Recorder { truth, ..exact() }, &sweep).log.rows.iter().map(|row| row.readings[0]).collect()
    };
    let moments: Vec<f64> = sweep.exact_moments.iter().map(|row| row[0]).collect();
    let none = TrueErrors::default();
    let near = |a: f64, b: f64| (a - b).abs() < 1e-15;
    let shifted = readings(TrueErrors { zero: 2e-4, zero_drift: 1e-6, gain: 0.08, ..none });
    for k in (0..ROWS).step_by(777) {
        assert!(near(shifted[k], 1.08 * moments[k] + 2e-4 + 1e-6 * sweep.truth[k].t));
    }
    // Fifteen rows later: on the slopes of the triangle by 15 steps of 2 uN m.
    let late = readings(TrueErrors { delay: 0.05, ..none });
    assert!((late[500] - moments[515]).abs() < 1e-12 && (late[1500] - moments[1515]).abs() < 1e-12);
    let log = record(&Recorder { truth: TrueErrors { odometry_translation: 0.05, ..none }, ..exact() }, &sweep).log;
    assert!((log.rows[1000].odom_from_robot.x - 1.05).abs() < 1e-9);
    let heading = Recorder { truth: TrueErrors { heading: 0.35, ..none }, heading_noise: Some(0.0), ..exact() };
    assert!((record(&heading, &sweep).log.rows[7].heading.unwrap() - 0.35).abs() < 1e-12);
}

#[test]
fn a_declared_robot_and_map_come_back_from_the_true_ones() {
    let errors =
        TrueErrors { mount: [1e-3, -2e-3, 0.1], length: 3e-3, rigidity: 0.1, map_scale: 0.25, ..Default::default() };
    let declared = Robot::default();
    let truth = errors.true_robot(&declared).unwrap();
    let whisker = &truth.whiskers[0];
    assert!((whisker.beam.length - 0.078).abs() < 1e-12 && (whisker.robot_from_whisker.theta - 0.1).abs() < 1e-12);
    let back = errors.declared_robot(&truth).unwrap();
    assert!((back.whiskers[0].beam.length - 0.075).abs() < 1e-15);
    assert!(
        (back.whiskers[0].beam.flexural_rigidity / declared.whiskers[0].beam.flexural_rigidity - 1.0).abs() < 1e-12
    );
    let world = demo::arena().unwrap();
    let map = errors.declared_map(&world).unwrap();
    assert!((map.bounds().size().x * 1.25 - world.bounds().size().x).abs() < 1e-9);
    assert_eq!(map.boundaries().len(), world.boundaries().len());
    assert!((errors.on_declared_map(Pose2::new(0.5, 0.25, 1.0)).x - 0.4).abs() < 1e-12);
    assert!(TrueErrors { length: -0.075, ..errors }.true_robot(&declared).is_err());
}
