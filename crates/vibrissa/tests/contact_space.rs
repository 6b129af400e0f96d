//! Contacts in space: against Cosserat rods of an independent program, and through noise, in and out of the plane.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "data/random.rs"]
mod random;

use random::Random;
use vibrissa::Stop;
use vibrissa::beam::{BendingPlane, Load, Whisker, moment_mode_in_space, point_mode};
use vibrissa::config::ContactOptions;
use vibrissa::flow::sensor_log::{Channel, LogRow, Quantity, SensorLog};
use vibrissa::plane::{Pose2, Vec2};
use vibrissa::tasks::contact::{ContactKind, SpaceReport, contact_in_space};
use vibrissa::world::{MomentNoise, MountedWhisker, Robot};

/// A log of both moments (N m) at places of the base.
fn log_of(rows: &[(Pose2, [f64; 2])]) -> SensorLog {
    let channel = |quantity| Channel { whisker: String::new(), quantity };
    let row = |(k, (base, moments)): (usize, &(Pose2, [f64; 2]))| LogRow {
        t: 0.1 * k as f64,
        odom_from_robot: *base,
        readings: moments.to_vec(),
        heading: None,
        line: k + 2,
    };
    SensorLog {
        channels: vec![channel(Quantity::Moment), channel(Quantity::Across)],
        rows: rows.iter().enumerate().map(row).collect(),
        ..SensorLog::default()
    }
}

fn robot(relative: f64, absolute: f64) -> Robot {
    let noise = MomentNoise { moment_relative: relative, moment_absolute: absolute };
    Robot { whiskers: vec![MountedWhisker { noise, ..MountedWhisker::default() }], ..Robot::default() }
}

fn found(log: &SensorLog, robot: &Robot) -> SpaceReport {
    contact_in_space(log, robot, &ContactOptions::default(), &Stop::default(), &mut |_, _| {}).unwrap()
}

fn kinds(report: &SpaceReport) -> Vec<&str> {
    report.events.iter().map(|event| event.kind).collect()
}

/// The moments of a straight whisker whose side is pushed to a point in its frame.
fn moments([x, y, z]: [f64; 3]) -> [f64; 2] {
    let r = y.hypot(z);
    let bend = point_mode(&Whisker::default(), Vec2::new(x, r), Load::Normal).unwrap().remove(0);
    [bend.moment * y / r, bend.moment * z / r]
}

/// One row of the table: the base (m), the contact in the whisker's frame (m), its arc length (m), both moments (N m).
struct Row {
    case: String,
    base: Vec2,
    contact: [f64; 3],
    s_a: f64,
    moments: [f64; 2],
}

fn table() -> Vec<Row> {
    let text = include_str!("../../../validation/space/contacts.csv");
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let n = |k: usize| cells[k].parse::<f64>().unwrap();
        Row {
            case: cells[0].to_owned(),
            base: Vec2::new(n(2), n(3)),
            contact: [n(4), n(5), n(6)],
            s_a: n(7),
            moments: [n(8), n(9)],
        }
    };
    text.lines().skip(1).map(row).collect()
}

/// How far a contact is from the truth, at worst of a case: along the whisker (m), away from its axis (m), around it (rad).
type Off = [f64; 3];

fn worse(worst: &mut Off, off: Off) {
    worst.iter_mut().zip(off).for_each(|(worst, off)| *worst = worst.max(off.abs()));
}

/// From both moments and the arc length of each row.
fn by_arc_length(rows: &[Row]) -> Off {
    let mut worst = [0.0; 3];
    for row in rows {
        let found = moment_mode_in_space(&Whisker::default(), row.moments, row.s_a, Load::Normal).unwrap().remove(0);
        let [x, y, z] = row.contact;
        worse(&mut worst, [found.x - x, found.r - y.hypot(z), found.plane.angle - z.atan2(y)]);
    }
    worst
}

/// From both moments and the base's way: the point that stands still.
fn by_log(rows: &[Row]) -> Off {
    let placed: Vec<(Pose2, [f64; 2])> =
        rows.iter().map(|row| (Pose2::new(row.base.x, row.base.y, 0.0), row.moments)).collect();
    let report = found(&log_of(&placed), &robot(0.01, 2e-6));
    assert_eq!(report.steps.len(), rows.len());
    let mut worst = [0.0; 3];
    for (step, row) in report.steps.iter().zip(rows) {
        assert_eq!(step.kind, ContactKind::Side, "{}", row.case);
        let (contact, [x, y, z]) = (step.contact.unwrap(), row.contact);
        let (r, angle) = (y.hypot(z), z.atan2(y));
        worse(&mut worst, [contact.x.value - x, contact.r.value - r, contact.angle.value - angle]);
        assert!(contact.x.holds(x) && contact.r.holds(r) && contact.angle.holds(angle), "{}: {contact:?}", row.case);
        assert!((step.s_a.unwrap() - row.s_a).abs() < 4e-4, "{}", row.case);
    }
    let is_flat = rows.iter().all(|row| row.contact[2].abs() < 1e-9);
    assert_eq!(kinds(&report).contains(&"out_of_plane"), !is_flat, "{}: {:?}", rows[0].case, report.events);
    assert!(!kinds(&report).contains(&"slides_around"), "{:?}", report.events);
    worst
}

/// A line of the page's table.
fn line(rows: &[Row], arc: Off, log: Off) -> String {
    let (first, last) = (&rows[0], &rows[rows.len() - 1]);
    let of = |row: &Row| {
        let [_, y, z] = row.contact;
        (1e3 * y.hypot(z), z.atan2(y).to_degrees(), 1e3 * row.moments[0].hypot(row.moments[1]))
    };
    let (from, to) = (of(first), of(last));
    format!(
        "| {} | {:.0} to {:.0} mm | {:.0} to {:.0}° | {:.1} to {:.1} mN m | {:.1} µm, {:.1} µm, {:.3} mrad | {:.2} mm, {:.2} mm, {:.1} mrad |",
        first.case.replace('_', " "),
        from.0,
        to.0,
        from.1,
        to.1,
        from.2,
        to.2,
        1e6 * arc[0],
        1e6 * arc[1],
        1e3 * arc[2],
        1e3 * log[0],
        1e3 * log[1],
        1e3 * log[2]
    )
}

#[test]
fn moments_of_cosserat_rods_lead_to_their_contacts_as_the_page_says() {
    const PAGE: &str = include_str!("../../../docs/contact-and-profile.md");
    let rows = table();
    assert!(rows.len() >= 40, "{}", rows.len());
    let mut lines = Vec::new();
    for rows in rows.chunk_by(|a, b| a.case == b.case) {
        let (arc, log) = (by_arc_length(rows), by_log(rows));
        lines.push(line(rows, arc, log));
        println!("{}", lines[lines.len() - 1]);
        assert!(arc[0] < 1e-5 && arc[1] < 1e-5 && arc[2] < 1e-5, "{}: {arc:?}", rows[0].case);
        assert!(log[0] < 4e-4 && log[1] < 2e-4 && log[2] < 3e-3, "{}: {log:?}", rows[0].case);
    }
    let missing: Vec<&String> = lines.iter().filter(|line| !PAGE.contains(line.as_str())).collect();
    assert!(missing.is_empty(), "not in docs/contact-and-profile.md: {missing:#?}");
}

#[test]
fn noise_within_the_declared_errors_stays_within_the_bands() {
    let mut random = Random(8);
    let (mut steps, mut off) = (0, Vec::new());
    for _ in 0..40 {
        let angle = random.signed(core::f64::consts::PI);
        let (x, r) = (random.between(0.035, 0.055), random.between(0.003, 0.007));
        let point = [x, r * angle.cos(), r * angle.sin()];
        let (relative, absolute) = (random.between(0.01, 0.05), random.between(1e-6, 2e-5));
        // Away from the point, a little forward, with a turn.
        let way = |k: i32| {
            let s = 2.5e-4 * f64::from(k);
            Pose2::new(0.3 * s, -s * point[1].signum(), random_turn(k, point[1].signum()))
        };
        let rows: Vec<(Pose2, [f64; 2])> = (0..32)
            .map(|k| {
                let base = way(k);
                let at = base.inverse().transform_point(Vec2::new(point[0], point[1]));
                let truth = moments([at.x, at.y, point[2]]);
                // |true - read| <= relative |read| + absolute.
                let read = truth.map(|m| {
                    let error = random.signed(1.0);
                    (m + error * absolute) / (1.0 - error * m.signum() * relative)
                });
                (base, read)
            })
            .collect();
        let report = found(&log_of(&rows), &robot(relative, absolute));
        for step in report.steps.iter().filter(|step| step.kind == ContactKind::Side) {
            let at = step.odom_from_whisker.inverse().transform_point(Vec2::new(point[0], point[1]));
            let contact = step.contact.unwrap();
            let (r, angle) = (at.y.hypot(point[2]), point[2].atan2(at.y));
            let turn = vibrissa::plane::wrap_angle(angle - contact.angle.value);
            assert!(contact.x.holds(at.x) && contact.r.holds(r), "{contact:?} {at:?} {r}");
            assert!(contact.angle.holds(contact.angle.value + turn), "{contact:?} {angle}");
            off.push((contact.x.value - at.x).abs());
            steps += 1;
        }
    }
    off.sort_by(f64::total_cmp);
    println!("{steps} steps of 1280, x {:.2} mm off in the median", 1e3 * off[off.len() / 2]);
    assert!(steps > 1100, "{steps}");
    assert!(off[off.len() / 2] < 1e-3, "{}", off[off.len() / 2]);
}

fn random_turn(k: i32, side: f64) -> f64 {
    -side * 2e-3 * f64::from(k)
}

#[test]
fn a_tip_that_slides_has_its_angle_and_its_place() {
    let whisker = Whisker::default();
    // The tip goes round the whisker while it stays bent; the base drives along.
    let rows: Vec<(Pose2, [f64; 2])> = (0..60)
        .map(|k| {
            let (size, angle) = (4e-3 + 3e-5 * f64::from(k), 0.02 * f64::from(k) - 0.3);
            (Pose2::new(3e-4 * f64::from(k), 0.0, 0.0), [size * angle.cos(), size * angle.sin()])
        })
        .collect();
    let report = found(&log_of(&rows), &robot(0.02, 1e-5));
    assert!(report.steps.iter().all(|step| step.kind == ContactKind::Tip));
    for (step, (_, read)) in report.steps.iter().zip(&rows) {
        let told = step.contact.unwrap();
        let planar = moment_mode_in_space(&whisker, *read, whisker.length, Load::Normal).unwrap().remove(0);
        assert!((told.x.value - planar.x).abs() < 1e-12 && (told.r.value - planar.r).abs() < 1e-12);
        // Errors at the ends of their bounds, of both moments, stay within.
        for (a, b) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            let errors = read.map(|m| 0.02 * m.abs() + 1e-5);
            let moved = [read[0] + a * errors[0], read[1] + b * errors[1]];
            let other = moment_mode_in_space(&whisker, moved, whisker.length, Load::Normal).unwrap().remove(0);
            assert!(told.x.holds(other.x) && told.r.holds(other.r) && told.angle.holds(other.plane.angle), "{told:?}");
        }
    }
    assert!(
        kinds(&report).contains(&"slides_around") && kinds(&report).contains(&"out_of_plane"),
        "{:?}",
        report.events
    );
    // The same in the plane: nothing to warn of.
    let flat: Vec<(Pose2, [f64; 2])> = rows.iter().map(|(base, m)| (*base, [m[0].hypot(m[1]), 0.0])).collect();
    assert_eq!(kinds(&found(&log_of(&flat), &robot(0.02, 1e-5))), ["contact"]);
}

#[test]
fn what_cannot_be_told_is_refused_or_said() {
    let rows = [(Pose2::IDENTITY, [5e-3, 1e-3])];
    let log = log_of(&rows);
    let options = ContactOptions::default();
    let refused = |log: &SensorLog, robot: &Robot| {
        contact_in_space(log, robot, &options, &Stop::default(), &mut |_, _| {}).unwrap_err().to_string()
    };
    let planar = SensorLog { channels: log.channels[..1].to_vec(), ..log.clone() };
    assert!(refused(&planar, &robot(0.05, 2e-5)).contains("across"), "{}", refused(&planar, &robot(0.05, 2e-5)));
    let mut curved = robot(0.05, 2e-5);
    curved.whiskers[0].beam.curvature = 4.0;
    assert!(refused(&log, &curved).contains("curved"), "{}", refused(&log, &curved));
    // Moments beyond any tip's, no numbers, none at all.
    for moments in [[1.0, 0.0], [f64::NAN, 1e-3], [f64::INFINITY, 0.0], [1e-300, 5e-3], [0.0, 0.0]] {
        let report = found(&log_of(&vec![(Pose2::IDENTITY, moments); 9]), &robot(0.05, 2e-5));
        for step in &report.steps {
            assert!(step.contact.is_none_or(|c| c.x.value.is_finite() && c.r.value.is_finite()), "{step:?}");
        }
    }
    let report = found(&log_of(&[(Pose2::IDENTITY, [1.0, 0.0])]), &robot(0.05, 2e-5));
    assert_eq!((report.steps[0].kind, report.steps[0].contact), (ContactKind::Unknown, None));
    assert!(kinds(&report).contains(&"no_point"));
    // What the plane tells, and its warning's number.
    assert!((BendingPlane::of([5e-3, 1e-3]).out_of_plane() - 0.2f64.atan()).abs() < 1e-12);
}
