//! Both transverse axes of a chip that stands askew: moments recovered from the field of a dipole, with cross-talk and noise.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "data/random.rs"]
mod random;

use random::Random;
use vibrissa::beam::{Load, Whisker, point_mode};
use vibrissa::config::CurveOptions;
use vibrissa::flow::sensor_log::{Channel, LogRow, Quantity, SensorLog};
use vibrissa::io::calibration::{from_json, to_json};
use vibrissa::io::log::foreign::{Format, Recording};
use vibrissa::plane::{Pose2, Vec2};
use vibrissa::sensing::SensingChain;
use vibrissa::tasks::calibrate::{Constant, Labelled, calibrate_contacts, fit_moment_curve, fit_moment_plane};
use vibrissa::world::calibration::{Calibration, MomentPlane};
use vibrissa::world::{MountedWhisker, Robot};

/// A sensor whose chip is turned about all of its axes, whose magnet sits askew, in the field of the earth.
struct Askew {
    chain: SensingChain,
    chip: [[f64; 3]; 3],
}

impl Askew {
    fn new() -> Self {
        let straight = SensingChain::default();
        let [x, _, _] = straight.magnet_offset;
        let strength = straight.magnet_moment[0];
        let chain = SensingChain {
            magnet_offset: [x, 0.25e-3, -0.2e-3],
            magnet_moment: [0.99 * strength, 0.09 * strength, -0.07 * strength],
            ambient: [18e-6, -5e-6, 44e-6],
            ..straight
        };
        // About its own normal by 14°, then about the next axes by 4° and 3°.
        let turn = |axis: usize, degrees: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
            let mut m = [[0.0; 3]; 3];
            (m[axis][axis], m[i][i], m[j][j], m[i][j], m[j][i]) = (1.0, cos, cos, -sin, sin);
            m
        };
        Self { chain, chip: product(product(turn(2, 14.0), turn(0, 4.0)), turn(1, 3.0)) }
    }

    /// What the driver reads, to counts, with normal errors (T).
    fn read(&self, moments: [f64; 2], noise: f64, random: &mut Random) -> Vec<f64> {
        let flux = self.chain.flux_in_space(moments);
        let normal = |random: &mut Random| (0..12).map(|_| random.unit()).sum::<f64>() - 6.0;
        let felt = [0, 1, 2].map(|k| (0..3).map(|j| self.chip[k][j] * flux[j]).sum::<f64>() + noise * normal(random));
        self.chain.chip.flux(self.chain.chip.counts(felt)).to_vec()
    }
}

fn product(a: [[f64; 3]; 3], b: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

/// Contacts all around the axis, up to about 9 mN m, with their true moments.
fn contacts(sensor: &Askew, n: usize, noise: f64, random: &mut Random) -> (Labelled, Vec<[f64; 2]>) {
    let whisker = Whisker::default();
    let mut made = Labelled {
        source: "made".into(),
        contacts: Vec::new(),
        angles: Vec::new(),
        inputs: ["bx", "by", "bz"].map(str::to_owned).to_vec(),
        readings: Vec::new(),
        moments: None,
    };
    let mut truth = Vec::new();
    while made.contacts.len() < n {
        let contact = Vec2::from_angle(random.between(0.0, 0.5)) * (whisker.length * random.between(0.5, 0.95));
        let Some(bend) = point_mode(&whisker, contact, Load::Normal).unwrap().into_iter().next() else { continue };
        if bend.moment > 9e-3 {
            continue;
        }
        let angle = random.signed(core::f64::consts::PI);
        let moments = [bend.moment * angle.cos(), bend.moment * angle.sin()];
        made.readings.push(sensor.read(moments, noise, random));
        made.contacts.push(contact);
        made.angles.push(angle);
        truth.push(moments);
    }
    (made, truth)
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = values.fold((0.0, 0.0), |(sum, n), v| (sum + v * v, n + 1.0));
    (sum / n).sqrt()
}

fn worst(plane: &MomentPlane, made: &Labelled, truth: &[[f64; 2]], k: usize) -> Vec<f64> {
    let off = |(readings, truth): (&Vec<f64>, &[f64; 2])| plane.moments(readings).map(|m| (m[k] - truth[k]).abs());
    made.readings.iter().zip(truth).filter_map(|pair| off(pair).ok()).collect()
}

#[test]
fn both_moments_come_back_from_a_chip_that_stands_askew() {
    let (sensor, mut random, options) = (Askew::new(), Random(5), CurveOptions::default());
    // A moment of 9 mN m moves the flux by 1.3 mT; 2 µT are 14 µN m.
    let noise = 2e-6;
    let (made, _) = contacts(&sensor, 600, noise, &mut random);
    let explained = made.explain(&Whisker::default()).unwrap();
    let plane = fit_moment_plane(&made, &explained, &options).unwrap();
    let (fresh, fresh_truth) = contacts(&sensor, 600, noise, &mut random);
    for k in 0..2 {
        let errors = worst(&plane, &fresh, &fresh_truth, k);
        let (size, beyond) = (rms(errors.iter().copied()), errors.iter().filter(|e| **e > plane.bound[k]).count());
        println!("axis {k}: {:.2e} N m RMS on new contacts, bound {:.2e}, beyond {beyond}", size, plane.bound[k]);
        assert!(errors.len() > 590 && beyond <= 5, "{} {beyond}", errors.len());
        assert!(size < 1.5 * plane.residual_rms[k] && plane.bound[k] < 12.0 * plane.residual_rms[k], "{plane:?}");
        // The noise is 2 µT over 0.1 T/(N m) or more.
        assert!(size < 6e-5, "{size}");
    }
    // What one axis alone makes of the same: the cross-talk is its error.
    let one = fit_moment_curve(&made, &explained, &options).unwrap();
    let alone = rms(fresh.readings.iter().zip(&fresh_truth).filter_map(|(b, m)| Some(one.moment(b).ok()? - m[0])));
    println!("one axis alone: {alone:.2e} N m RMS");
    assert!(alone > 5.0 * rms(worst(&plane, &fresh, &fresh_truth, 0).into_iter()), "{alone}");
    // The rest is the field without contact, along the chip's axes.
    let rest = sensor.read([0.0; 2], 0.0, &mut random);
    let signals = plane.moments(&rest).unwrap();
    assert!(signals.iter().all(|m| m.abs() < 4e-5), "{signals:?}");
    // Through the file nothing changes.
    let calibration = Calibration { plane: Some(plane.clone()), ..Calibration::default() };
    let text = to_json(&calibration).to_string();
    assert_eq!(from_json(&text, "cal.json").unwrap(), calibration);
    // Both signals at their ends at once are beyond all contacts.
    let far = plane.moments(&sensor.read([17e-3, 17e-3], 0.0, &mut random)).unwrap_err().to_string();
    assert!(far.contains("beyond the calibrated range") && far.contains("not both ends at once"), "{far}");
}

#[test]
fn without_noise_the_surfaces_follow_the_dipole() {
    let (sensor, mut random) = (Askew::new(), Random(9));
    let (made, _) = contacts(&sensor, 600, 0.0, &mut random);
    let explained = made.explain(&Whisker::default()).unwrap();
    let plane = fit_moment_plane(&made, &explained, &CurveOptions::default()).unwrap();
    println!("{:?} {:?}", plane.residual_rms, plane.bound);
    assert!(plane.residual_rms.iter().all(|rms| *rms < 2e-5), "{:?}", plane.residual_rms);
    assert!(plane.coefficients[0][6..].iter().any(|c| *c != 0.0), "the third degree is needed");
}

#[test]
fn faults_of_labelled_contacts_in_space_are_told() {
    let (sensor, mut random, options) = (Askew::new(), Random(3), CurveOptions::default());
    let whisker = Whisker::default();
    let (made, _) = contacts(&sensor, 200, 1e-6, &mut random);
    let fails =
        |made: &Labelled| fit_moment_plane(made, &made.explain(&whisker).unwrap(), &options).unwrap_err().to_string();
    // From one side only.
    let half = Labelled { angles: made.angles.iter().map(|a| 0.3 * a).collect(), ..made.clone() };
    assert!(fails(&half).contains("all around"), "{}", fails(&half));
    // One axis of the chip.
    let one = Labelled {
        inputs: vec!["by".into()],
        readings: made.readings.iter().map(|r| vec![r[1]]).collect(),
        ..made.clone()
    };
    assert!(fails(&one).contains("two or more of bx,by,bz"), "{}", fails(&one));
    // Two columns that are one axis twice.
    let twice = Labelled {
        inputs: vec!["bx".into(), "by".into()],
        readings: made.readings.iter().map(|r| vec![r[1], -2.0 * r[1]]).collect(),
        ..made.clone()
    };
    assert!(fails(&twice).contains("apart"), "{}", fails(&twice));
    let few = Labelled { contacts: made.contacts[..30].to_vec(), ..made };
    assert!(fails(&few).contains("40 or more"), "{}", fails(&few));
    // Files with a plane that is none.
    for (plane, words) in [
        ("{}", "plane.inputs"),
        (
            r#"{"inputs": ["bx", "by"], "rest": [0, 0], "directions": [[1, 0], [0]], "ranges": [[0, 1], [0, 1]], "reach": 1,
            "coefficients": [[0,1,0,0,0,0,0,0,0,0], [0,0,1,0,0,0,0,0,0,0]], "residual_rms": [0, 0], "hysteresis": 0,
            "bound": [0, 0], "samples": 1}"#,
            "one length",
        ),
        (
            r#"{"inputs": ["bx", "by"], "rest": [0, 0], "directions": [[1, 0], [0, 1]], "ranges": [[0, 1], [0, 1]], "reach": 1,
            "coefficients": [[0,1,0], [0,0,1]], "residual_rms": [0, 0], "hysteresis": 0, "bound": [0, 0],
            "samples": 1}"#,
            "two lists of 10 numbers",
        ),
    ] {
        let text = format!(r#"{{"format": "vibrissa calibration", "version": 1, "plane": {plane}}}"#);
        let told = from_json(&text, "cal.json").unwrap_err().to_string();
        assert!(told.contains(words) && told.contains("cal.json"), "{told}");
    }
}

#[test]
fn a_recording_with_a_column_z_calibrates_the_plane() {
    let (sensor, mut random) = (Askew::new(), Random(21));
    let (made, _) = contacts(&sensor, 200, 1e-6, &mut random);
    let mut text = String::from("x,y,z,bx,by,bz\n");
    for ((contact, angle), b) in made.contacts.iter().zip(&made.angles).zip(&made.readings) {
        let (y, z) = (contact.y * angle.cos(), contact.y * angle.sin());
        text.push_str(&format!("{},{y},{z},{},{},{}\n", contact.x, b[0], b[1], b[2]));
    }
    let recording = Recording::from_bytes(text.as_bytes(), Format::Csv, "contacts.csv").unwrap();
    let found = calibrate_contacts(&recording, "contacts.csv", &Whisker::default(), &[]).unwrap().calibration;
    assert!(found.moment.is_none() && found.tip_deflection.is_some());
    let plane = found.plane.unwrap();
    assert!(plane.bound.iter().all(|b| *b < 2e-4), "{:?}", plane.bound);
    let refused =
        calibrate_contacts(&recording, "contacts.csv", &Whisker::default(), &[Constant::TipRatio]).unwrap_err();
    assert!(refused.to_string().contains("z = 0"), "{refused}");
    // A column z of zeros is the plane as before.
    let flat = "x,y,z,ay\n".to_owned()
        + &(0..40).map(|i| format!("0.06,{},0,{}\n", 1e-4 * f64::from(i - 20), 10 * (i - 20))).collect::<String>();
    let recording = Recording::from_bytes(flat.as_bytes(), Format::Csv, "flat.csv").unwrap();
    let found = calibrate_contacts(&recording, "flat.csv", &Whisker::default(), &[]).unwrap().calibration;
    assert!(found.moment.is_some() && found.plane.is_none());
}

/// The contacts that the page about building a sensor asks for, pressed on the sensor that it draws.
#[test]
fn the_contacts_of_the_build_page_calibrate_a_sensor_that_stands_askew() {
    let (sensor, mut random) = (Askew::new(), Random(17));
    let whisker = Whisker { base_stiffness: sensor.chain.stiffness, ..Whisker::default() };
    // The mean of 300 readings with 5 µT of noise.
    let noise = 5e-6 / 300_f64.sqrt();
    let mut moments_of = |x: f64, r: f64, degrees: f64| {
        let bend = point_mode(&whisker, Vec2::new(x, r), Load::Normal).unwrap().remove(0);
        let (sin, cos) = degrees.to_radians().sin_cos();
        let moments = [bend.moment * cos, bend.moment * sin];
        ([x, r * cos, r * sin], moments, sensor.read(moments, noise, &mut random))
    };
    let mut text = String::from("x,y,z,bx,by,bz\n");
    let (mut rows, mut largest) = (0, 0.0_f64);
    for x in [0.040, 0.055, 0.070] {
        for eighth in 0..8 {
            let at_rest = sensor.read([0.0; 2], noise, &mut Random(rows));
            text.push_str(&format!("{x},0,0,{},{},{}\n", at_rest[0], at_rest[1], at_rest[2]));
            for r in [0.006, 0.012, 0.018, 0.018, 0.012, 0.006] {
                let (at, moments, b) = moments_of(x, r, 45.0 * f64::from(eighth));
                text.push_str(&format!("{},{},{},{},{},{}\n", at[0], at[1], at[2], b[0], b[1], b[2]));
                largest = largest.max(moments[0].hypot(moments[1]));
                rows += 1;
            }
        }
    }
    assert_eq!(rows, 144, "as the page says");
    let recording = Recording::from_bytes(text.as_bytes(), Format::Csv, "contacts.csv").unwrap();
    let plane = calibrate_contacts(&recording, "contacts.csv", &whisker, &[]).unwrap().calibration.plane.unwrap();
    println!("bound {:?}, rms {:?}, largest {largest}", plane.bound, plane.residual_rms);
    // Above 5 % of the largest moment the page says that something slips.
    assert!(plane.bound.iter().all(|bound| *bound < 0.05 * largest), "{:?} {largest}", plane.bound);
    let mut beyond = 0;
    for k in 0..200 {
        let (x, r, angle) = (0.042 + 1.3e-4 * f64::from(k), 0.003 + 7e-5 * f64::from(k), 37.0 * f64::from(k));
        let (_, truth, b) = moments_of(x, r, angle);
        let found = plane.moments(&b).unwrap();
        beyond += usize::from((0..2).any(|axis| (found[axis] - truth[axis]).abs() > plane.bound[axis]));
    }
    assert!(beyond <= 4, "{beyond} of 200 contacts between them are off by more than the bound");
}

#[test]
fn a_log_of_flux_becomes_one_of_both_moments() {
    let (sensor, mut random) = (Askew::new(), Random(2));
    let (made, _) = contacts(&sensor, 200, 1e-6, &mut random);
    let explained = made.explain(&Whisker::default()).unwrap();
    let plane = fit_moment_plane(&made, &explained, &CurveOptions::default()).unwrap();
    let bound = plane.bound[0].max(plane.bound[1]);
    let path = std::env::temp_dir().join(format!("vibrissa-plane-{}.json", std::process::id()));
    let text = to_json(&Calibration { plane: Some(plane), ..Calibration::default() }).to_string();
    std::fs::write(&path, text).unwrap();
    let whisker = MountedWhisker { calibration: Some(path.clone()), ..MountedWhisker::default() };
    let absolute = whisker.noise.moment_absolute;
    let robot = Robot { whiskers: vec![whisker], ..Robot::default() };
    let quantities = [Quantity::FluxX, Quantity::FluxY, Quantity::FluxZ];
    let truth = [[0.0, 0.0], [6e-3, 0.0], [3e-3, -5e-3]];
    let row = |(k, moments): (usize, &[f64; 2])| LogRow {
        t: k as f64,
        odom_from_robot: Pose2::IDENTITY,
        readings: sensor.read(*moments, 0.0, &mut Random(1)),
        heading: None,
        line: k + 2,
    };
    let log = SensorLog {
        channels: quantities.map(|quantity| Channel { whisker: String::new(), quantity }).to_vec(),
        rows: truth.iter().enumerate().map(row).collect(),
        ..SensorLog::default()
    };
    let (log, robot) = vibrissa::io::calibrated(&log, &robot).unwrap();
    std::fs::remove_file(&path).unwrap();
    assert_eq!(log.channels[3..].iter().map(Channel::column).collect::<Vec<_>>(), ["moment", "across"]);
    assert!((robot.whiskers[0].noise.moment_absolute - absolute - bound).abs() < 1e-15);
    for (row, truth) in log.rows.iter().zip(truth) {
        assert!((0..2).all(|k| (row.readings[3 + k] - truth[k]).abs() <= bound), "{:?} {truth:?}", row.readings);
    }
}
