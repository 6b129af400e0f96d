//! `reproduce.json`: every number and every word of the page.

use serde_json::{Map, Value, json};
use vibrissa::{Error, Result};
use vibrissa_reproduce::ReproduceOptions;
use vibrissa_reproduce::{Cell, Comparison, Figure, Reproduction, Section, Table};

/// The answer as pretty JSON with a line end; `runtime` is there only when a time is given.
pub(super) fn text(answer: &Reproduction, options: &ReproduceOptions, seconds: Option<f64>) -> Result<String> {
    let mut numbers = Map::new();
    for number in answer.numbers() {
        let value = json!({ "value": number.value, "unit": number.unit, "shown": number.shown() });
        numbers.insert(number.key.clone(), value);
    }
    let mut all = json!({
        "simulated": true,
        "options": { "seeds": options.seeds, "sweeps": options.sweeps, "trials": options.trials, "only": options.only },
        "about": super::page::ABOUT,
        "sections": answer.sections.iter().map(section).collect::<Vec<Value>>(),
        "numbers": numbers,
    });
    if let Some(seconds) = seconds {
        all["runtime"] = json!({ "total_s": seconds });
    }
    let text = serde_json::to_string_pretty(&all);
    text.map(|text| text + "\n").map_err(|error| Error::data(format!("cannot write the result as JSON ({error})")))
}

fn section(section: &Section) -> Value {
    json!({
        "key": section.key,
        "title": section.title,
        "text": section.text,
        "figures": section.figures.iter().map(figure).collect::<Vec<Value>>(),
        "tables": section.tables.iter().map(table).collect::<Vec<Value>>(),
        "comparisons": section.comparisons.iter().map(comparison).collect::<Vec<Value>>(),
    })
}

/// A figure with the words in its pictures, which hold the numbers along the axes.
fn figure(figure: &Figure) -> Value {
    let panels: Vec<Value> =
        figure.panels.iter().map(|panel| json!({ "key": panel.key, "words": drawn_words(&panel.svg) })).collect();
    json!({
        "key": figure.key,
        "paper": figure.paper,
        "ours": figure.ours,
        "difference": figure.difference,
        "panels": panels,
    })
}

/// What stands in the text elements of a picture.
fn drawn_words(svg: &str) -> Vec<&str> {
    svg.split("<text ")
        .skip(1)
        .filter_map(|piece| piece.split_once('>')?.1.split_once("</text>"))
        .map(|p| p.0)
        .collect()
}

fn table(table: &Table) -> Value {
    let row = |row: &Vec<Cell>| row.iter().map(cell).collect::<Vec<Value>>();
    json!({
        "key": table.key,
        "title": table.title,
        "head": table.head,
        "rows": table.rows.iter().map(row).collect::<Vec<Vec<Value>>>(),
    })
}

fn comparison(comparison: &Comparison) -> Value {
    json!({
        "what": comparison.what,
        "paper": cell(&comparison.paper),
        "ours": cell(&comparison.ours),
        "difference": cell(&comparison.difference),
        "reason": comparison.reason,
    })
}

/// Words, or the key of a number.
fn cell(cell: &Cell) -> Value {
    match cell {
        Cell::Words(words) => json!(words),
        Cell::Number(number) => json!({ "number": number.key }),
    }
}
