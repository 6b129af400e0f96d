//! Calibrations of whiskers whose constants are known: recovered within what the covariance allows, bounds that hold, and
//! small deflections against integrals and full elastica.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "data/random.rs"]
mod random;

use random::Random;
use vibrissa::beam::{
    Load, Rod, Stretch, Whisker, deflection_per_force, moment_per_travel, moment_per_turn, point_mode,
};
use vibrissa::config::{CurveOptions, TapOptions};
use vibrissa::flow::taps::taps;
use vibrissa::io::log::foreign::{Format, Recording};
use vibrissa::plane::Vec2;
use vibrissa::tasks::calibrate::{
    Constant, DistanceSet, Labelled, Shaft, fit_constants, fit_distance, fit_moment_curve, fit_tip_deflection,
    leave_one_out,
};
use vibrissa::world::calibration::{Calibration, Motion};

/// A standard normal number (sum of twelve uniform ones).
fn normal(random: &mut Random) -> f64 {
    (0..12).map(|_| random.unit()).sum::<f64>() - 6.0
}

fn cone() -> Whisker {
    Whisker { length: 0.18, flexural_rigidity: 1.4e-2, tip_ratio: 1.0 / 3.0, base_stiffness: 1.1, ..Whisker::default() }
}

#[test]
fn a_jointed_shaft_deflects_as_its_integral() {
    let wire = |length, flexural_rigidity| Stretch { length, flexural_rigidity, tip_ratio: 1.0, diameter: None };
    let whisker =
        Whisker { base_stiffness: 0.5, ..Whisker::of_stretches(&[wire(0.03, 2e-4), wire(0.05, 5e-5)]).unwrap() };
    let s_a: f64 = 0.06;
    // ∫ (s_a - s)² / EI ds over both wires, by hand, and the base.
    let expected = (s_a.powi(3) - 0.03f64.powi(3)) / 3.0 / 2e-4 + 0.03f64.powi(3) / 3.0 / 5e-5 + s_a * s_a / 0.5;
    assert!((deflection_per_force(&whisker, s_a).unwrap() / expected - 1.0).abs() < 1e-8);
}

#[test]
fn small_deflections_agree_with_the_integral_and_with_the_rod() {
    let mut random = Random(3);
    for _ in 0..60 {
        let whisker = Whisker {
            length: random.between(0.02, 0.4),
            flexural_rigidity: 10f64.powf(random.between(-5.0, -1.0)),
            tip_ratio: random.between(0.05, 1.0),
            base_stiffness: if random.unit() < 0.2 { f64::INFINITY } else { 10f64.powf(random.between(-3.0, 1.0)) },
            ..Whisker::default()
        };
        let s_a = whisker.length * random.between(0.05, 1.0);
        let n = 4000;
        let width = s_a / f64::from(n);
        let integral: f64 = (0..n)
            .map(|i| (f64::from(i) + 0.5) * width)
            .map(|s| {
                let radius = 1.0 - (1.0 - whisker.tip_ratio) * s / whisker.length;
                (s_a - s).powi(2) / (whisker.flexural_rigidity * radius.powi(4)) * width
            })
            .sum();
        let expected = integral + s_a * s_a / whisker.base_stiffness;
        let influence = deflection_per_force(&whisker, s_a).unwrap();
        assert!((influence / expected - 1.0).abs() < 1e-5, "{influence} {expected}");
        assert!((moment_per_turn(&whisker, s_a).unwrap() * influence / (s_a * s_a) - 1.0).abs() < 1e-12);
        assert!((moment_per_travel(&whisker, s_a).unwrap() * influence / s_a - 1.0).abs() < 1e-12);
        // The full elastica under a force so small that slopes are 1e-4.
        let force = -1e-4 * s_a / influence;
        let bend = &Rod::new(&whisker).unwrap().force_mode(force, s_a, Load::Normal).unwrap()[0];
        assert!((bend.contact.y / (force * influence) - 1.0).abs() < 1e-6, "{} {}", bend.contact.y, force * influence);
    }
    assert!(deflection_per_force(&cone(), 0.19).is_err() && deflection_per_force(&cone(), 0.0).is_err());
}

/// Slopes of taps at these distances with this relative noise.
fn tapped(whisker: &Whisker, gain: f64, noise: f64, random: &mut Random) -> Vec<DistanceSet> {
    (0..11)
        .map(|i| 0.065 + 0.01 * f64::from(i))
        .map(|d| {
            let slope = gain / whisker.flexural_rigidity * moment_per_turn(whisker, d).unwrap();
            // One slope for each distance: its median is itself, so that the covariance can be judged.
            DistanceSet { source: String::new(), samples: vec![(d, slope * (noise * normal(random)).exp())] }
        })
        .collect()
}

#[test]
fn shaft_constants_come_back_within_their_covariance() {
    let (whisker, gain) = (cone(), 8400.0);
    let compliance = whisker.flexural_rigidity / whisker.base_stiffness;
    let shaft = Shaft { motion: Motion::Turn, length: 0.18, tip_ratio: Some(whisker.tip_ratio), clamped: false };
    let exact = fit_distance(&tapped(&whisker, gain, 0.0, &mut Random(1)), shaft).unwrap().model;
    assert!((exact.gain / gain - 1.0).abs() < 1e-9 && (exact.base_compliance / compliance - 1.0).abs() < 1e-8);
    // And with the taper free, which is found by a search.
    let free = Shaft { tip_ratio: None, ..shaft };
    let found = fit_distance(&tapped(&whisker, gain, 0.0, &mut Random(1)), free).unwrap().model;
    assert!((found.tip_ratio - whisker.tip_ratio).abs() < 1e-4, "{found:?}");
    let (mut random, runs, mut sum) = (Random(7), 300, 0.0);
    for _ in 0..runs {
        let fit = fit_distance(&tapped(&whisker, gain, 0.01, &mut random), shaft).unwrap();
        let [a, b] = [(fit.model.gain / gain).ln(), fit.model.base_compliance - compliance];
        let c = &fit.covariance;
        let determinant = c[0][0] * c[1][1] - c[0][1] * c[1][0];
        sum += (c[1][1] * a * a - 2.0 * c[0][1] * a * b + c[0][0] * b * b) / determinant;
    }
    // With the variance estimated from 9 spare residuals the statistic is 2 F(2, 9): mean 2 * 9 / 7 = 2.57, standard
    // deviation of the mean of 300 about 0.2.
    let mean = sum / f64::from(runs);
    assert!((1.9..3.3).contains(&mean), "{mean}");
}

#[test]
fn left_out_distances_come_back_and_too_few_are_refused() {
    let whisker = cone();
    let shaft = Shaft { motion: Motion::Turn, length: 0.18, tip_ratio: Some(whisker.tip_ratio), clamped: false };
    let sets = tapped(&whisker, 8400.0, 0.0, &mut Random(1));
    let answers = leave_one_out(&sets, shaft).unwrap();
    assert_eq!(answers.len(), 11);
    assert!(answers.iter().all(|a| (a.found.unwrap() - a.truth).abs() < 1e-8));
    let error = fit_distance(&sets[..1], shaft).unwrap_err();
    assert!(error.is_data() && error.to_string().contains("2 or more"), "{error}");
    assert!(leave_one_out(&sets[..2], shaft).unwrap().is_empty());
}

/// A recording of taps: rest with swings, a ramp at `slope` that rings, a plateau and release.
fn tap_recording(slopes: &[f64], rest: f64, random: &mut Random) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let (rate, mut t, mut y, mut onsets) = (800.0, Vec::new(), Vec::new(), Vec::new());
    for slope in slopes {
        let onset = 0.5 + random.between(0.0, 1e-3);
        onsets.push(t.len() as f64 / rate + onset);
        let (phase, base) = (random.between(0.0, 6.0), t.len() as f64 / rate);
        for i in 0..900 {
            let s = f64::from(i) / rate - onset;
            let reach = slope * 0.06;
            let touched = (slope * s.clamp(0.0, 0.06)) * (1.0 - ((s - 0.1) / 0.03).clamp(0.0, 1.0));
            let ringing = if (0.0..0.1).contains(&s) { 0.02 * reach * (630.0 * s + phase).sin() } else { 0.0 };
            t.push(base + f64::from(i) / rate);
            y.push(rest + touched + ringing + 10.0 * normal(random));
        }
    }
    (t, y, onsets)
}

#[test]
fn tap_slopes_and_onsets_are_found_for_both_signs_and_noise_alone_gives_none() {
    let mut random = Random(5);
    let slopes = [150e3, -80e3, 60e3, -140e3, 200e3];
    let (t, y, onsets) = tap_recording(&slopes, 33_000.0, &mut random);
    let found = taps(&t, &y, &TapOptions::default());
    assert_eq!(found.len(), slopes.len(), "{found:?}");
    for ((tap, slope), onset) in found.iter().zip(slopes).zip(onsets) {
        assert!((tap.slope / slope - 1.0).abs() < 0.02, "{tap:?} {slope}");
        assert!((tap.t - onset).abs() < 1.5e-3 && (tap.rest - 33_000.0).abs() < 10.0, "{tap:?} {onset}");
    }
    let quiet: Vec<f64> = t.iter().map(|_| 10.0 * normal(&mut random)).collect();
    assert!(taps(&t, &quiet, &TapOptions::default()).is_empty());
    let strange = [f64::NAN, f64::INFINITY, 0.0, -1e300];
    let mixed: Vec<f64> = (0..t.len()).map(|i| strange[i % 4]).collect();
    assert!(taps(&t, &mixed, &TapOptions::default()).len() < 10);
    assert!(taps(&[], &[], &TapOptions::default()).is_empty());
    // Cut in the middle of a ramp, the tap is not half believed.
    assert_eq!(taps(&t[..420], &y[..420], &TapOptions::default()).len(), 0);
}

/// Labelled contacts of a whisker through a bent sensor: signal = a M + b M³ along a tilted direction.
fn labelled(whisker: &Whisker, n: usize, noise: f64, random: &mut Random) -> (Labelled, Vec<f64>) {
    let rod = Rod::new(whisker).unwrap();
    let (mut contacts, mut readings, mut moments) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..n {
        let reach = whisker.length * random.between(0.5, 0.97);
        let contact = Vec2::from_angle(random.signed(0.45)) * reach;
        let bends = rod.point_mode(contact, Load::Normal).unwrap();
        let Some(bend) = bends.first() else { continue };
        let signal = 2.0 * bend.moment + 8e3 * bend.moment.powi(3);
        contacts.push(contact);
        readings.push(vec![
            1e-5 + 0.6 * signal + noise * normal(random),
            -3e-5 - 0.8 * signal + noise * normal(random),
            4e-4 + noise * normal(random),
        ]);
        moments.push(bend.moment);
    }
    let inputs = ["bx", "by", "bz"].map(str::to_owned).to_vec();
    (Labelled { source: "made".into(), contacts, inputs, readings, angles: Vec::new(), moments: None }, moments)
}

#[test]
fn flux_becomes_moment_on_an_elastic_base_and_the_bound_holds_for_new_contacts() {
    let whisker = Whisker { base_stiffness: 0.02, ..Whisker::default() };
    let mut random = Random(11);
    let (made, truth) = labelled(&whisker, 300, 2e-5, &mut random);
    let explained = made.explain(&whisker).unwrap();
    assert_eq!(explained.len(), truth.len());
    for e in &explained {
        assert!((e.moment - truth[e.row]).abs() < 1e-9 * truth[e.row].abs() + 1e-15, "{e:?} {}", truth[e.row]);
    }
    let curve = fit_moment_curve(&made, &explained, &CurveOptions::default()).unwrap();
    let sigma = 2e-5 / 2.0;
    println!("{curve:?}");
    assert!(curve.residual_rms < 1.2 * sigma && curve.residual_rms > 0.4 * sigma, "{}", curve.residual_rms);
    assert!(curve.bound > 2.0 * curve.residual_rms && curve.bound < 6.0 * sigma);
    let (fresh, truth) = labelled(&whisker, 300, 2e-5, &mut random);
    let off = |row: usize| (curve.at(curve.signal(&fresh.readings[row])) - truth[row]).abs();
    let beyond = (0..truth.len()).filter(|&row| off(row) > curve.bound).count();
    // A new contact exceeds the largest of n with probability 1 / (n + 1); five of 300 would be a hundredth of a chance.
    assert!(beyond <= 5, "{beyond}");
    // Read back through the file, nothing changes.
    let calibration =
        Calibration { moment: Some(curve), tip_deflection: fit_tip_deflection(&explained), ..Calibration::default() };
    let text = vibrissa::io::calibration::to_json(&calibration).to_string();
    assert_eq!(vibrissa::io::calibration::from_json(&text, "cal.json").unwrap(), calibration);
    let curve = calibration.moment.unwrap();
    assert!(curve.moment(&[1.0, 1.0, 1.0]).unwrap_err().to_string().contains("calibrated range"));
}

/// Readings that are up to 10 % off make no moment too small: the gain of a straight sensor comes back within 0.3 %.
#[test]
fn errors_of_the_readings_do_not_pull_the_moments_down() {
    let mut random = Random(31);
    let (mut made, truth) = labelled(&Whisker::default(), 600, 0.0, &mut random);
    let explained = made.explain(&Whisker::default()).unwrap();
    let mut gains = Vec::new();
    for _ in 0..10 {
        made.readings = truth.iter().map(|m| vec![2.0 * m * (1.0 + 0.1 * random.signed(1.0)), 0.0, 0.0]).collect();
        let curve = fit_moment_curve(&made, &explained, &CurveOptions::default()).unwrap();
        gains.push((curve.at(curve.signal(&[2e-3, 0.0, 0.0])) - curve.at(curve.signal(&[0.0; 3]))) / 1e-3 - 1.0);
    }
    let mean = gains.iter().sum::<f64>() / 10.0;
    assert!(mean.abs() < 3e-3, "{gains:?}");
}

#[test]
fn hysteresis_is_seen_as_wide_as_it_is() {
    let whisker = Whisker::default();
    let (mut contacts, mut readings) = (Vec::new(), Vec::new());
    for i in 0..400 {
        // Up and down, five times; the reading lags by 10 µN m on each way.
        let phase = f64::from(i % 80) / 40.0;
        let (share, lag) = if phase < 1.0 { (phase, -1e-5) } else { (2.0 - phase, 1e-5) };
        let contact = Vec2::new(0.06, 0.001 + 0.012 * share);
        let moment = point_mode(&whisker, contact, Load::Normal).unwrap()[0].moment;
        contacts.push(contact);
        readings.push(vec![100.0 * (moment + lag)]);
    }
    let made = Labelled {
        source: "made".into(),
        contacts,
        inputs: vec!["ax".into()],
        readings,
        angles: Vec::new(),
        moments: None,
    };
    let explained = made.explain(&whisker).unwrap();
    let curve = fit_moment_curve(&made, &explained, &CurveOptions::default()).unwrap();
    assert!((curve.hysteresis - 2e-5).abs() < 4e-6, "{}", curve.hysteresis);
    let tip = fit_tip_deflection(&explained).unwrap();
    assert!(tip.residual_rms < 2e-4 && tip.at(1.0).is_none(), "{tip:?}");
}

#[test]
fn rigidity_and_base_come_back_within_their_covariance() {
    let truth = Whisker { base_stiffness: 0.03, ..Whisker::default() };
    let start = Whisker { flexural_rigidity: 2.2e-4, base_stiffness: f64::INFINITY, ..truth };
    let free = [Constant::FlexuralRigidity, Constant::BaseCompliance];
    let (mut random, runs, mut sum) = (Random(13), 25, 0.0);
    let (made, moments) = labelled(&truth, 40, 0.0, &mut random);
    for _ in 0..runs {
        let noisy = moments.iter().map(|m| m + 1e-5 * normal(&mut random)).collect();
        let made = Labelled { moments: Some(noisy), ..made.clone() };
        let fit = fit_constants(&made, &[], &start, &free).unwrap();
        assert!((fit.residual_rms / 1e-5 - 1.0).abs() < 0.5, "{}", fit.residual_rms);
        let c = &fit.covariance;
        let [a, b] =
            [fit.flexural_rigidity - truth.flexural_rigidity, 1.0 / fit.base_stiffness - 1.0 / truth.base_stiffness];
        let determinant = c[0][0] * c[1][1] - c[0][1] * c[1][0];
        sum += (c[1][1] * a * a - 2.0 * c[0][1] * a * b + c[0][0] * b * b) / determinant;
    }
    // 2 F(2, 38) has mean 2.11; the mean of 25 has a standard deviation of about 0.45.
    let mean = sum / f64::from(runs);
    assert!((0.9..3.6).contains(&mean), "{mean}");
    // Without measured moments the rigidity cannot be told.
    let error = fit_constants(&made, &[], &start, &free).unwrap_err();
    assert!(error.is_usage(), "{error}");
}

#[test]
fn faulty_calibrations_are_named() {
    let cases = [
        ("{", "not valid JSON"),
        ("{}", "no calibration"),
        ("{\"format\": \"vibrissa calibration\", \"version\": 9}", "another version: 9 (allowed: 1)"),
        ("{\"format\": \"vibrissa calibration\", \"version\": 1, \"distance\": {}}", "distance.channel: missing"),
        ("{\"format\": \"vibrissa calibration\", \"version\": 1, \"moment\": {\"inputs\": [1]}}", "moment.inputs: [1]"),
    ];
    for (text, words) in cases {
        let error = vibrissa::io::calibration::from_json(text, "cal.json").unwrap_err();
        let shown = error.to_string();
        assert!(
            error.is_data() && shown.contains(words) && shown.contains("cal.json") && shown.contains("help:"),
            "{shown}"
        );
    }
}

#[test]
fn labelled_logs_need_contacts_and_one_kind_of_reading() {
    let read = |text: &str| {
        let recording = Recording::from_bytes(text.as_bytes(), Format::Csv, "log.csv")?;
        Labelled::from_recording(&recording)
    };
    assert_eq!(read("x,y,ax\n0.05,0.01,3\nbad\n").unwrap().contacts.len(), 1);
    for (text, words) in [
        ("x,ax\n0.05,3\n", "no column `y`"),
        ("x,y\n0.05,0.01\n", "no readings"),
        ("x,y,ax,bx\n0.05,0.01,3,1e-6\n", "both flux and counts"),
    ] {
        let error = read(text).unwrap_err();
        assert!(error.is_data() && error.to_string().contains(words), "{error}");
    }
}

#[test]
fn a_base_is_told_from_raw_readings_through_a_bent_sensor() {
    let truth = Whisker { base_stiffness: 0.02, ..Whisker::default() };
    let (made, _) = labelled(&truth, 120, 2e-5, &mut Random(17));
    let signal: Vec<f64> = made.readings.iter().map(|r| 0.6 * r[0] - 0.8 * r[1]).collect();
    let fit = fit_constants(&made, &signal, &Whisker::default(), &[Constant::BaseCompliance]).unwrap();
    let std = fit.covariance[0][0].sqrt();
    let error = 1.0 / fit.base_stiffness - 50.0;
    println!("{error} {std}");
    assert!(error.abs() < 4.0 * std && std < 2.0, "{error} {std}");
}

#[test]
fn damaged_calibrations_never_panic() {
    let shaft = Shaft { motion: Motion::Turn, length: 0.18, tip_ratio: Some(0.3), clamped: false };
    let fit = fit_distance(&tapped(&cone(), 8400.0, 0.01, &mut Random(2)), shaft).unwrap();
    let (made, _) = labelled(&Whisker::default(), 40, 1e-5, &mut Random(4));
    let curve = fit_moment_curve(&made, &made.explain(&Whisker::default()).unwrap(), &CurveOptions::default()).unwrap();
    let whole =
        Calibration { moment: Some(curve), channel: "ax".into(), distance: Some(fit.model), ..Calibration::default() };
    let text = vibrissa::io::calibration::to_json(&whole).to_string();
    assert_eq!(vibrissa::io::calibration::from_json(&text, "cal.json").unwrap(), whole);
    let mut random = Random(6);
    let mut read = 0;
    for _ in 0..3000 {
        let mut bytes = text.clone().into_bytes();
        for _ in 0..=(random.unit() * 3.0) as usize {
            let at = (random.unit() * bytes.len() as f64) as usize;
            match (random.unit() * 3.0) as usize {
                0 => bytes[at] = b"0123456789-.e,[]{}\"n"[(random.unit() * 20.0) as usize],
                1 => drop(bytes.remove(at)),
                _ => bytes.insert(at, b"09-e,"[(random.unit() * 5.0) as usize]),
            }
        }
        let Ok(calibration) = vibrissa::io::calibration::from_json(&String::from_utf8_lossy(&bytes), "cal.json") else {
            continue;
        };
        read += 1;
        if let Some(curve) = &calibration.moment {
            let _ = curve.moment(&vec![1e-4; curve.inputs.len()]);
        }
        if let Some(model) = calibration.distance {
            let found = model.distance(1e5);
            assert!(found.is_none_or(|d| d.distance > 0.0 && d.distance <= model.length), "{model:?} {found:?}");
        }
    }
    assert!(read > 100, "{read}");
}

#[test]
fn taper_and_base_are_told_apart_also_at_the_ends_of_their_ranges() {
    let cases = [(1.0, 0.02, 1.0), (0.6, 0.05, 1.0), (0.5, f64::INFINITY, 0.9), (1.0, f64::INFINITY, 0.5)];
    for (tip_ratio, base_stiffness, begin) in cases {
        let truth = Whisker { base_stiffness, tip_ratio, ..Whisker::default() };
        let (made, moments) = labelled(&truth, 60, 0.0, &mut Random(19));
        let made = Labelled { moments: Some(moments), ..made };
        let start = Whisker { tip_ratio: begin, flexural_rigidity: 2.5e-4, ..Whisker::default() };
        let fit = fit_constants(&made, &[], &start, &Constant::ALL).unwrap();
        assert!((fit.tip_ratio - tip_ratio).abs() < 1e-4, "{fit:?}");
        assert!((1.0 / fit.base_stiffness - 1.0 / base_stiffness).abs() < 0.02, "{fit:?}");
        assert!((fit.flexural_rigidity / truth.flexural_rigidity - 1.0).abs() < 1e-4, "{fit:?}");
    }
}

#[test]
fn nothing_but_a_base_is_rigid_in_a_file() {
    let file = |largest: &str| {
        format!(
            r#"{{"format":"vibrissa calibration","version":1,"data":[],
                "tip_deflection":{{"coefficients":[2,3],"largest_moment":{largest},"residual_rms":5}}}}"#
        )
    };
    let read = vibrissa::io::calibration::from_json(&file("0.5"), "cal.json").unwrap();
    assert!((read.tip_deflection.unwrap().largest_moment - 0.5).abs() < 1e-15);
    let message = vibrissa::io::calibration::from_json(&file("\"inf\""), "cal.json").unwrap_err().to_string();
    assert!(message.contains("tip_deflection.largest_moment") && message.contains("a number"), "{message}");
}
