//! The answer in words, for people.

use super::{Run, Runtime, counted, fit};
use std::fmt::Write;
use std::path::PathBuf;
use vibrissa::figure::localization::verdict;
use vibrissa::flow::pose::{Event, Hypothesis, OdometryEstimate, Status};
use vibrissa::flow::trajectory::TrajectoryError;
use vibrissa::sets::Interval;

/// How many places and how many events are listed one by one.
const LISTED: usize = 8;

/// The answer, its width, what happened, how long it took, and where the files are.
pub(crate) fn text(run: &Run, error: Option<&TrajectoryError>, written: Option<&[PathBuf]>) -> String {
    let mut text = format!("{}\n", verdict(&run.answer));
    match run.answer.hypotheses.as_slice() {
        [] => {}
        _ if run.answer.status == Status::Inconsistent => {}
        [only] => estimate(&mut text, only),
        many => places(&mut text, many, run.answer.encloses),
    }
    if let Some(odometry) = &run.answer.odometry {
        corrections(&mut text, odometry);
    }
    text.push_str(&fit::text(&run.answer));
    if let Some(error) = error {
        truth(&mut text, error);
    }
    events(&mut text, &run.answer.events);
    runtime(&mut text, run.rows, &run.runtime);
    match written {
        Some(paths) => files(&mut text, paths),
        None => {
            text.push_str("\nNo files were written; add --out DIR for the trajectory, the state set and a figure.\n")
        }
    }
    text
}

// Writing into a string cannot fail, so the results of `writeln!` are dropped throughout.

fn estimate(text: &mut String, only: &Hypothesis) {
    let degrees = 1f64.to_degrees();
    let (pose, extent) = (only.pose, only.extent);
    let _ = writeln!(text, "\nestimate at the last row          extent of the place");
    for (name, value, range, factor, unit) in [
        ("x", pose.x, extent.x, 1e3, "mm"),
        ("y", pose.y, extent.y, 1e3, "mm"),
        ("heading", pose.theta, extent.theta, degrees, "deg"),
    ] {
        let _ = writeln!(text, "  {name:<8}{:>10.2} {unit:<12} {}", value * factor, interval(range, factor, unit));
    }
    if let Some((position, heading)) = only.bound() {
        let (position, heading) = (position * 1e3, heading * degrees);
        let _ = writeln!(text, "  expected error by the declared noise: {position:.3} mm, {heading:.3} deg (rms)");
    }
    if let Some(length) = only.ridge_length() {
        let _ = writeln!(text, "  open along a curve of {:.0} mm (`ridge` in the JSON)", length * 1e3);
    }
}

fn corrections(text: &mut String, odometry: &OdometryEstimate) {
    let off = |scale: f64, std: f64| format!("{:+.2} ± {:.2} %", 100.0 * (scale - 1.0), 100.0 * std);
    let _ = writeln!(
        text,
        "\nodometry, by what was felt: ways {}, turns {}, aside {:+.2} ± {:.2} deg",
        off(odometry.translation_scale, odometry.translation_scale_std),
        off(odometry.rotation_scale, odometry.rotation_scale_std),
        odometry.aside.to_degrees(),
        odometry.aside_std.to_degrees(),
    );
}

fn places(text: &mut String, many: &[Hypothesis], encloses: bool) {
    // Of a set its share, which is no probability.
    let weight = if encloses { " share" } else { "weight" };
    let _ = writeln!(text, "\n  place  {weight}      x mm      y mm  heading deg   extent: x mm, y mm, heading deg");
    for (index, hypothesis) in many.iter().take(LISTED).enumerate() {
        let (pose, extent) = (hypothesis.pose, hypothesis.extent);
        let (x, y, heading) = (pose.x * 1e3, pose.y * 1e3, pose.theta.to_degrees());
        let wide = [extent.x.width() * 1e3, extent.y.width() * 1e3, extent.theta.width().to_degrees()];
        let along = hypothesis.ridge_length().map(|length| format!("; along {:.0} mm", length * 1e3));
        let _ = writeln!(
            text,
            "  {:>5}  {:>4.0} %  {x:>8.2}  {y:>8.2}  {heading:>11.2}   {:.2}, {:.2}, {:.2}{}",
            index + 1,
            100.0 * hypothesis.weight,
            wide[0],
            wide[1],
            wide[2],
            along.unwrap_or_default()
        );
    }
    if many.len() > LISTED {
        let _ = writeln!(text, "  … and {} more places", many.len() - LISTED);
    }
}

fn truth(text: &mut String, error: &TrajectoryError) {
    let degrees = |angle: f64| angle.to_degrees();
    let _ = writeln!(
        text,
        "\nerror against the truth\n  at the end  {:.3} mm, {:.3} deg\n  mean        {:.3} mm, {:.3} deg over {}",
        error.final_position * 1e3,
        degrees(error.final_heading),
        error.mean_position * 1e3,
        degrees(error.mean_heading),
        counted(error.rows, "row", "rows")
    );
}

fn events(text: &mut String, events: &[Event]) {
    if events.is_empty() {
        return;
    }
    text.push_str("\nevents\n");
    // Of many the last that say more than that a whisker touches: the verdict rests on them.
    let touches = |event: &&Event| matches!(event.kind, "contact" | "lift_off");
    let told: Vec<&Event> = if events.len() > LISTED {
        let others: Vec<&Event> = events.iter().filter(|event| !touches(event)).collect();
        others[others.len().saturating_sub(LISTED)..].to_vec()
    } else {
        events.iter().collect()
    };
    for event in &told {
        let _ = writeln!(text, "  {:>9.3} s  {}: {}", event.t, event.kind, event.detail);
    }
    if events.len() > told.len() {
        let _ = writeln!(text, "  … and {}", counted(events.len() - told.len(), "more event", "more events"));
    }
}

fn runtime(text: &mut String, rows: usize, runtime: &Runtime) {
    let rows = counted(rows, "row", "rows");
    if runtime.updates == 0 {
        let _ = writeln!(text, "\n{rows}, no update, in {:.3} s", runtime.total_s);
        return;
    }
    let _ = writeln!(
        text,
        "\n{rows}, {} in {:.3} s; one update takes {} (median), {} (99th percentile)",
        counted(runtime.updates, "update", "updates"),
        runtime.total_s,
        duration(runtime.p50_us),
        duration(runtime.p99_us)
    );
}

/// A short time in µs, told in the unit that shows it.
fn duration(us: f64) -> String {
    if us < 999.5 { format!("{us:.0} µs") } else { format!("{:.1} ms", us * 1e-3) }
}

fn files(text: &mut String, paths: &[PathBuf]) {
    text.push_str("\nwritten\n");
    for path in paths {
        let _ = writeln!(text, "  {}", path.display());
    }
}

fn interval(range: Interval, factor: f64, unit: &str) -> String {
    if range.is_empty() {
        return "empty".into();
    }
    format!("{:.2} to {:.2} {unit}", range.lo() * factor, range.hi() * factor)
}

#[cfg(test)]
mod tests {
    use super::{Event, events};

    #[test]
    fn of_many_events_those_are_listed_that_the_verdict_rests_on() {
        let event = |t: f64, kind: &'static str| Event { t, kind, detail: String::new() };
        let touches = (0..12).map(|k| event(f64::from(k), if k % 2 == 0 { "contact" } else { "lift_off" }));
        let mut all: Vec<Event> = touches.collect();
        all.push(event(12.0, "enclosed"));
        let mut text = String::new();
        events(&mut text, &all);
        assert!(
            text.contains("enclosed") && !text.contains("lift_off") && text.contains("and 12 more events"),
            "{text}"
        );
        // Of few all are.
        let mut text = String::new();
        events(&mut text, &all[..3]);
        assert!(text.contains("lift_off") && !text.contains("more event"), "{text}");
    }
}
