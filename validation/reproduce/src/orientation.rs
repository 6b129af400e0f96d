//! Orientation sensing, which the paper announces: how fast the state set shrinks with a compass and without.

use super::Section;
use super::ground::{self, SWEEPS};
use super::report::line;
use vibrissa::Result;
use vibrissa::config::PossibilisticOptions;
use vibrissa::figure::chart_plate;
use vibrissa::flow::pose::{Localization, StepRecord};
use vibrissa::flow::sensor_log::SensorLog;
use vibrissa::localize;
use vibrissa::localizer::Method;
use vibrissa::sim::SweepNoise;

/// Bound on the compass's error (rad).
const COMPASS: f64 = 0.05;
/// Area at which the place is small (m²): 10 mm by 10 mm.
const SMALL: f64 = 1e-4;

pub(super) fn section() -> Result<Section> {
    let mut section = Section::new("orientation", "Orientation sensing");
    let (map, robot) = (ground::arena()?, ground::robot(1.0));
    let sweep = ground::arena_sweep(&map, SWEEPS[0].way, &SweepNoise::seeded(1))?;
    let mut with = sweep.log.clone();
    for (row, truth) in with.rows.iter_mut().zip(&sweep.truth) {
        row.heading = Some(truth.map_from_robot.theta + 0.5 * COMPASS);
    }
    let method =
        Method::Possibilistic(PossibilisticOptions { heading_error: COMPASS, ..PossibilisticOptions::default() });
    let run = |log: &SensorLog| localize(log, &map, &robot, &method, &mut |_row| {});
    let (without, with) = (run(&sweep.log)?, run(&with)?);
    let start = sweep.contacts.first().map_or(0, |touch| touch.row);
    let travel = |t: f64| {
        let rows: Vec<_> = sweep.truth[start..].iter().take_while(|row| row.t <= t).collect();
        rows.windows(2)
            .map(|w| 1e3 * w[0].map_from_robot.position().distance(w[1].map_from_robot.position()))
            .sum::<f64>()
    };
    // The cover reaches beyond the walls, where no base can be.
    let free = super::possibilistic::free_area(&map);
    let curve = |answer: &Localization| -> Vec<(f64, f64)> {
        let step = |step: &StepRecord| (travel(step.t), (1e4 * step.area_m2.min(free)).max(1e-6).log10());
        answer.steps.iter().step_by(4).chain(answer.steps.last()).map(step).collect()
    };
    let needed = |answer: &Localization| {
        let large = answer.steps.iter().rposition(|step| step.area_m2 > SMALL);
        large.map_or(answer.steps.first(), |last| answer.steps.get(last + 1)).map_or(f64::NAN, |step| travel(step.t))
    };
    section.show(
        "area",
        [
            "Announced in the introduction (“we assess how orientation sensing contributes to faster reduction of state \
             uncertainty”); no figure and no number follow.",
            "The area of the possibilistic state set along the first sweep, with and without a compass that is off by up to 3°. \
             It is that of a cover, which is never less than the set's; no more than all free space counts.",
            "",
        ],
        vec![chart_plate(
            "Area of the places that explain the log",
            "way since the first touch, mm",
            "log10 of the area in cm²",
            &[line("touch alone", "series hue1", curve(&without)), line("touch and compass", "series hue0", curve(&with))],
        )],
    );
    section.tell("alone", needed(&without), 0, "mm");
    section.tell("compass", needed(&with), 0, "mm");
    section.say(
        "Without a compass the set is smaller than 1 cm² for good after {orientation.alone} mm of sweep, with one after \
         {orientation.compass} mm.",
    );
    let end = |answer: &Localization| answer.steps.last().map_or(f64::NAN, |step| 1e6 * step.area_m2);
    section.find(
        "Area at the end of the sweep, touch alone",
        "end_alone",
        "no number",
        (end(&without), 2, "mm²"),
        "Guaranteed to hold the truth.",
    );
    section.find(
        "Area at the end of the sweep, with the compass",
        "end_compass",
        "no number",
        (end(&with), 2, "mm²"),
        "Likewise. A cover from outside need not shrink in step: this one may end larger than that of touch alone.",
    );
    Ok(section)
}
