//! How the readings fit what was declared, in words: what is off, what contradicts, where the path is not sure, what to try.

use std::fmt::Write;
use vibrissa::flow::pose::{ConsistencyReport, Localization, Nuisance, Status, Stretch};

/// How many stretches and how many remedies are told one by one.
const LISTED: usize = 5;

// Writing into a string cannot fail, so the results of `writeln!` are dropped throughout.

/// The paragraphs that the answer asks for; empty where all is as declared or nothing is told.
pub(super) fn text(answer: &Localization) -> String {
    let mut text = String::new();
    let off: Vec<&Nuisance> = answer.nuisances.iter().filter(|nuisance| nuisance.is_significant()).collect();
    if !off.is_empty() {
        text.push_str("\nby what was felt\n");
    }
    for nuisance in off {
        let _ = writeln!(text, "  {}", nuisance.sentence());
    }
    if let Some(report) = &answer.consistency {
        consistency(&mut text, report, answer.status == Status::Inconsistent);
    }
    doubts(&mut text, &answer.unsure);
    text
}

fn consistency(text: &mut String, report: &ConsistencyReport, contradicts: bool) {
    let ConsistencyReport { statistic, most, correlation_time, worst, remedies } = report;
    let contradicts = contradicts || statistic > most;
    if statistic.is_finite() {
        let alike = if *correlation_time > 0.0 {
            format!("; errors stay alike for {:.0} ms", 1e3 * correlation_time)
        } else {
            String::new()
        };
        let verdict = if contradicts { "the readings contradict what is declared" } else { "the readings fit" };
        let _ = writeln!(
            text,
            "\n{verdict}: consistency {statistic:.2}, at most {most:.2} within the declared bounds{alike}"
        );
    }
    if let Some((Stretch { from, to }, there)) = worst.filter(|_| contradicts) {
        let _ = writeln!(text, "  worst from {from:.3} to {to:.3} s: {there:.2}");
    }
    for remedy in remedies.iter().take(LISTED) {
        let fits =
            if remedy.statistic.is_finite() { format!(", consistency {:.2}", remedy.statistic) } else { String::new() };
        let _ = writeln!(text, "  try: {} ({}{fits})", remedy.change, remedy.status);
    }
}

fn doubts(text: &mut String, unsure: &[Stretch]) {
    if unsure.is_empty() {
        return;
    }
    text.push_str("\nthe path is not sure\n");
    for Stretch { from, to } in unsure.iter().take(LISTED) {
        let _ = writeln!(text, "  from {from:.3} to {to:.3} s");
    }
    if unsure.len() > LISTED {
        let _ = writeln!(text, "  … and in {} more stretches", unsure.len() - LISTED);
    }
}

#[cfg(test)]
mod tests {
    use super::text;
    use vibrissa::flow::pose::{ConsistencyReport, Localization, Nuisance, NuisanceQuantity, Remedy, Status, Stretch};

    fn answer(nuisances: &[(NuisanceQuantity, Option<&str>, f64, f64)]) -> Localization {
        let nuisance = |&(quantity, whisker, estimate, std): &(NuisanceQuantity, Option<&str>, f64, f64)| Nuisance {
            quantity,
            whisker: whisker.map(str::to_owned),
            estimate,
            std,
            bound: 1.0,
        };
        Localization { nuisances: nuisances.iter().map(nuisance).collect(), ..crate::output::no_answer() }
    }

    #[test]
    fn what_is_off_by_more_than_two_deviations_is_told() {
        use NuisanceQuantity::{Delay, Gain, Length, MapScale, MountHeading, MountX, Rigidity, Zero, ZeroDrift};
        let told = text(&answer(&[
            (Zero, Some("w0"), 2.1e-4, 2e-5),
            (Zero, Some("w1"), 1e-5, 2e-5),
            (ZeroDrift, Some("w0"), -3e-6, 1e-6),
            (MountX, Some("w0"), -5.1e-4, 1.2e-5),
            (MountHeading, Some("w0"), 0.0175, 0.001),
            (Length, Some("w0"), -4e-4, 1e-4),
            (Rigidity, Some("w0"), 0.02, 0.004),
            (Gain, Some("w0"), -0.08, 0.01),
            (Delay, None, 0.0203, 0.001),
            (MapScale, None, -0.03, 0.002),
        ]));
        let lines: Vec<&str> = told.lines().skip(1).map(str::trim).collect();
        assert_eq!(
            lines,
            [
                "by what was felt",
                "the zero of w0 was off by +0.210 ± 0.020 mN m",
                "the zero of w0 drifted by -3.0 ± 1.0 uN m/s",
                "the mount of w0 was off in x by -0.510 ± 0.012 mm",
                "the mount of w0 was turned by +1.003 ± 0.057 deg",
                "w0 was 0.40 ± 0.10 mm shorter than declared",
                "w0 was 2.00 ± 0.40 % stiffer than declared",
                "the readings of w0 were 8.0 ± 1.0 % too small",
                "readings were taken 20.3 ± 1.0 ms later than the odometry",
                "the world was 3.00 ± 0.20 % smaller than the map",
            ]
        );
    }

    #[test]
    fn contradictions_are_told_with_what_to_try() {
        let remedy = |change: &str, statistic, status| Remedy { change: change.into(), statistic, status };
        let mut answer = answer(&[]);
        assert_eq!(text(&answer), "");
        answer.consistency = Some(ConsistencyReport {
            statistic: 8.25,
            most: 1.3,
            correlation_time: 0.12,
            worst: Some((Stretch { from: 1.2, to: 1.8 }, 25.0)),
            remedies: vec![
                remedy("the sign of w0.moment is the other way round", 0.9, Status::Localized),
                remedy("readings come 20 ms later", f64::NAN, Status::Ambiguous),
            ],
        });
        answer.unsure = vec![Stretch { from: 0.5, to: 0.75 }];
        assert_eq!(
            text(&answer),
            "\nthe readings contradict what is declared: consistency 8.25, at most 1.30 within the declared bounds; \
             errors stay alike for 120 ms\n  worst from 1.200 to 1.800 s: 25.00\n  \
             try: the sign of w0.moment is the other way round (localized, consistency 0.90)\n  \
             try: readings come 20 ms later (ambiguous)\n\nthe path is not sure\n  from 0.500 to 0.750 s\n"
        );
        let fits = ConsistencyReport { statistic: 1.0, correlation_time: 0.0, ..answer.consistency.clone().unwrap() };
        answer.consistency = Some(ConsistencyReport { remedies: Vec::new(), ..fits });
        answer.unsure.clear();
        assert_eq!(text(&answer), "\nthe readings fit: consistency 1.00, at most 1.30 within the declared bounds\n");
    }
}
