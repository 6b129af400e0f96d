//! One whisker: the table for people, the JSON, and the files.

use super::Report;
use super::figure::figure;
use super::input::{Given, Known};
use serde_json::{Value, json};
use std::fmt::Write;
use vibrissa::beam::{Bend, Whisker};
use vibrissa::figure::numbers::{fixed, significant};
use vibrissa::{Error, Result};

/// Points along the whisker in `beam.csv` and in the JSON.
const POINTS: usize = 101;

pub(super) fn report(given: Given, known: &Known, whisker: &Whisker, json: bool) -> Result<Report> {
    let bends = known.solve(given, whisker)?;
    let text = if json {
        let solutions = bends.iter().map(|b| with_strain(solution(b, whisker), b, whisker));
        let value = json!({ "solutions": solutions.collect::<Vec<_>>() });
        format!("{value:#}\n")
    } else {
        table(&bends, whisker)
    };
    let mut warnings: Vec<String> = bends.iter().enumerate().filter_map(|(i, b)| overstrained(i, b, whisker)).collect();
    if bends.is_empty() {
        warnings.push(format!("no equilibrium: {}", given.why_none()));
    }
    let files = vec![("beam.csv", shapes(&bends, whisker)?), ("beam.svg", figure(&bends, whisker.length))];
    Ok(Report { text, warnings, files })
}

/// Adds the largest curvature and strain to one equilibrium.
fn with_strain(mut value: Value, bend: &Bend, whisker: &Whisker) -> Value {
    if let Some(largest) = bend.largest_strain_of(whisker) {
        value["largest_strain"] = json!({ "s": largest.s, "curvature": largest.curvature, "strain": largest.strain });
    }
    value
}

/// The warning that a whisker would not spring back.
fn overstrained(index: usize, bend: &Bend, whisker: &Whisker) -> Option<String> {
    let largest = bend.largest_strain_of(whisker)?;
    (largest.strain > whisker.strain_limit).then(|| {
        format!(
            "solution {index}: the surface is strained by {:.2} % at {:.1} mm from the base, beyond the limit of {} %: the whisker would stay bent",
            1e2 * largest.strain,
            1e3 * largest.s,
            1e2 * whisker.strain_limit
        )
    })
}

/// One equilibrium in SI.
pub(super) fn solution(bend: &Bend, whisker: &Whisker) -> Value {
    let (tip, force) = (bend.tip(whisker.length), bend.force_vector());
    let shape: Vec<[f64; 2]> = bend.shape(whisker.length, POINTS).iter().map(|p| [p.x, p.y]).collect();
    json!({
        "force": bend.force,
        "s_a": bend.s_a,
        "phi_a": bend.phi_a,
        "beta": bend.beta,
        "x": bend.contact.x,
        "y": bend.contact.y,
        "moment": bend.moment,
        "force_vector": [force.x, force.y],
        "reaction": [-force.x, -force.y, -bend.moment],
        "base_angle": bend.base_angle(),
        "tip": [tip.x, tip.y],
        "tip_displacement": [tip.x - whisker.length, tip.y],
        "energy": bend.energy(),
        "shape": shape,
    })
}

fn table(bends: &[Bend], whisker: &Whisker) -> String {
    if bends.is_empty() {
        return "no equilibrium\n".into();
    }
    let mut text = String::from(
        "   force      s_a    phi_a     beta        x        y   moment    tip x    tip y\n\
         \x20      N       mm      deg      deg       mm       mm    mN m       mm       mm\n",
    );
    for b in bends {
        let tip = whisker_mm(b.tip(whisker.length));
        let contact = whisker_mm(b.contact);
        let [phi, beta] = [b.phi_a, b.beta].map(|angle| fixed(angle.to_degrees(), 3));
        let _ = writeln!(
            text,
            "{:>8} {:8.3} {phi:>8} {beta:>8} {:>8} {:>8} {:>8} {:>8} {:>8}",
            significant(b.force, 4),
            b.s_a * 1e3,
            contact[0],
            contact[1],
            significant(b.moment * 1e3, 4),
            tip[0],
            tip[1],
        );
    }
    text
}

fn whisker_mm(point: vibrissa::plane::Vec2) -> [String; 2] {
    [point.x, point.y].map(|coordinate| fixed(coordinate * 1e3, 3))
}

/// The shapes as a table, SI.
fn shapes(bends: &[Bend], whisker: &Whisker) -> Result<String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let mut write = |row: [String; 6]| writer.write_record(row).map_err(|e| Error::data(format!("beam.csv: {e}")));
    write(["solution", "s", "x", "y", "slope", "curvature"].map(String::from))?;
    for (i, bend) in bends.iter().enumerate() {
        for (s, p) in bend.shape_points(whisker.length, POINTS) {
            let numbers = [s, p.position.x, p.position.y, p.slope, p.curvature].map(|v| format!("{v:?}"));
            let [s, x, y, slope, curvature] = numbers;
            write([i.to_string(), s, x, y, slope, curvature])?;
        }
    }
    text_of(writer)
}

pub(super) fn text_of(writer: csv::Writer<Vec<u8>>) -> Result<String> {
    let bytes = writer.into_inner().map_err(|e| Error::data(format!("beam.csv: {e}")))?;
    String::from_utf8(bytes).map_err(|e| Error::data(format!("beam.csv: {e}")))
}
