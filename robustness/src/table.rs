//! The tables, for people and for programs.

use crate::cells::Cell;
use crate::tally::{Tally, quantile};
use std::fmt::Write;

/// One row: a cell by one method.
pub(crate) struct Row {
    pub(crate) cell: Cell,
    pub(crate) undeclared: bool,
    pub(crate) method: &'static str,
    pub(crate) tally: Tally,
}

/// One table in Markdown.
pub(crate) fn markdown(rows: &[Row], undeclared: bool) -> String {
    let mut text = String::new();
    let title = if undeclared { "Errors that nobody declared" } else { "Noise laws within the declared bound" };
    let first = if undeclared { "error" } else { "law" };
    // Writing into a string cannot fail.
    let _ = write!(
        text,
        "## {title}\n\n| {first} | method | right/off/WRONG/ambiguous with/without/inconsistent | truth held | off without a word | \
         error mm: median, 95 % | heading deg: median | told mm: median | error / Cramer-Rao |\n\
         | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n"
    );
    for row in rows.iter().filter(|row| row.undeclared == undeclared) {
        let tally = &row.tally;
        let number = |value: f64, scale: f64| {
            if value.is_finite() { format!("{:.2}", scale * value) } else { "-".into() }
        };
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} of {} | {} | {}, {} | {} | {} | {} |",
            row.cell.text,
            row.method,
            tally.cells(),
            tally.held,
            tally.runs,
            tally.silent,
            number(quantile(&tally.errors, 0.5), 1e3),
            number(quantile(&tally.errors, 0.95), 1e3),
            number(quantile(&tally.turns, 0.5).to_degrees(), 1.0),
            number(quantile(&tally.bounds, 0.5), 1e3),
            number(quantile(&tally.ratios, 0.5), 1.0),
        );
    }
    text
}

/// All rows as JSON, SI units.
pub(crate) fn json(rows: &[Row]) -> String {
    let number = |value: f64| if value.is_finite() { format!("{value:e}") } else { "null".into() };
    let row = |row: &Row| {
        let tally = &row.tally;
        format!(
            "  {{\"table\": \"{}\", \"cell\": \"{}\", \"method\": \"{}\", \"runs\": {}, \"right\": {}, \"off\": {}, \"wrong\": {}, \
             \"ambiguous_with\": {}, \"ambiguous_without\": {}, \"inconsistent\": {}, \"held\": {}, \"silent\": {}, \
             \"error_median_m\": {}, \"error_95_m\": {}, \"heading_median_rad\": {}, \"told_median_m\": {}, \
             \"over_cramer_rao\": {}}}",
            if row.undeclared { "errors" } else { "laws" },
            row.cell.word,
            row.method,
            tally.runs,
            tally.outcomes[0],
            tally.outcomes[1],
            tally.outcomes[2],
            tally.outcomes[3],
            tally.outcomes[4],
            tally.outcomes[5],
            tally.held,
            tally.silent,
            number(quantile(&tally.errors, 0.5)),
            number(quantile(&tally.errors, 0.95)),
            number(quantile(&tally.turns, 0.5)),
            number(quantile(&tally.bounds, 0.5)),
            number(quantile(&tally.ratios, 0.5)),
        )
    };
    format!("[\n{}\n]\n", rows.iter().map(row).collect::<Vec<_>>().join(",\n"))
}
