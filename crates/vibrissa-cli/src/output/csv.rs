//! `states.csv` and `steps.csv`: numbers in the shortest form that reads back the same.

use std::fmt::Write;
use vibrissa::flow::pose::Localization;

/// The final state set as boxes (m, m, rad).
pub(crate) fn states(answer: &Localization) -> String {
    let mut text = String::from("x_min,x_max,y_min,y_max,theta_min,theta_max\n");
    for state in &answer.states {
        let (x, y, theta) = (state.x, state.y, state.theta);
        let row = [x.lo(), x.hi(), y.lo(), y.hi(), theta.lo(), theta.hi()];
        let _ = writeln!(text, "{}", row.map(|value| value.to_string()).join(","));
    }
    text
}

/// The size of the state set after each update (s, 1, m², m² rad).
pub(crate) fn steps(answer: &Localization) -> String {
    let mut text = String::from("t,components,area_m2,volume\n");
    for step in &answer.steps {
        let _ = writeln!(text, "{},{},{},{}", step.t, step.components, step.area_m2, step.volume);
    }
    text
}
