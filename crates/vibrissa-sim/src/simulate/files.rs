//! A sweep as the text of files, in SI units, each number in the shortest form that reads back the same.

use super::Sweep;
use std::fmt::Write;

/// The touches as CSV: `t,x,y`, the touched point in the map frame (s, m), with several whiskers their index, then where
/// along the whisker (m), with which part, and how it holds.
#[must_use]
pub fn contacts_csv(sweep: &Sweep) -> String {
    let many = sweep.log.channels.len() > 1;
    let mut text = String::from(if many { "t,x,y,whisker,s_a,part,grip\n" } else { "t,x,y,s_a,part,grip\n" });
    for touch in &sweep.contacts {
        let _ = write!(text, "{},{},{}", touch.t, touch.position.x, touch.position.y);
        if many {
            let _ = write!(text, ",{}", touch.whisker);
        }
        let _ = writeln!(text, ",{},{},{}", touch.s_a, touch.part.word(), touch.grip.word());
    }
    text
}
