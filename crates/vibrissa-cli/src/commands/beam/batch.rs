//! Many whiskers: a table in, the same table with the answers out.

use super::Report;
use super::input::{Given, Known, quantity};
use super::single::{solution, text_of};
use crate::interrupt::{Heedful, stop};
use crate::output::{counted, warn};
use serde_json::json;
use std::path::Path;
use vibrissa::beam::{Bend, Load, Whisker};
use vibrissa::config::budgets::{BATCH_BYTES, MOST_BATCH_ROWS};
use vibrissa::io::Dimension;
use vibrissa::io::text::read_text;
use vibrissa::tasks::batch;
use vibrissa::{Error, Result};

/// One row of the table, with what was found.
struct Row {
    line: usize,
    cells: csv::StringRecord,
    whisker: Whisker,
    bends: Vec<Bend>,
}

/// The table after solving.
struct Solved {
    headers: csv::StringRecord,
    rows: Vec<Row>,
    /// Rows that are missing, since an interrupt came before they were solved.
    missing: usize,
    warnings: Vec<String>,
}

/// Solves every row of `file`.
pub(super) fn report(
    file: &Path,
    given: Given,
    known: &Known,
    whisker: &Whisker,
    json: bool,
    stored: bool,
) -> Result<Report> {
    let text = read_text(file, "batch", BATCH_BYTES)?;
    let solved = solve(&text, given, known, whisker).map_err(|error| error.in_file(file))?;
    let table = table(&solved, given)?;
    let text = if json {
        format!("{:#}\n", as_json(&solved))
    } else if stored {
        summary(&solved)
    } else {
        table.clone()
    };
    let name = file.display();
    let warnings = solved.warnings.iter().map(|w| format!("{name}:{w}")).collect();
    Ok(Report { text, warnings, files: vec![("beam.csv", table)] })
}

fn solve(text: &str, given: Given, known: &Known, whisker: &Whisker) -> Result<Solved> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
    let fault = |error: &csv::Error| {
        let line = error.position().map_or(1, |p| p.line() as usize);
        Error::data(format!("broken table ({error})"))
            .at_line(line)
            .remedy("give each line as many fields as the header names, separated by commas")
    };
    let headers = reader.headers().map_err(|e| fault(&e))?.clone();
    let mut posed = Vec::new();
    for (index, record) in reader.records().enumerate() {
        let cells = record.map_err(|e| fault(&e))?;
        let line = cells.position().map_or(index + 2, |p| p.line() as usize);
        let cell = |name: &str| headers.iter().position(|h| h == name).and_then(|i| cells.get(i));
        let (known, whisker) = row(cell, known, whisker).map_err(|e| e.at_line(line))?;
        if posed.len() >= MOST_BATCH_ROWS {
            return Err(Error::data("the batch has too many rows")
                .at_line(line)
                .allowed(format!("up to {MOST_BATCH_ROWS}"))
                .remedy("split it into several tables"));
        }
        posed.push((line, cells, known, whisker));
    }
    if posed.is_empty() {
        return Err(Error::data("the batch has no rows").remedy("give a header line and at least one row"));
    }
    let heeds = Heedful::hurried();
    let (stop, all) = (stop(), posed.len());
    let answers = batch::map(&posed, batch::all_cores(), |(_, _, known, whisker)| {
        (!stop.is_asked()).then(|| known.solve(given, whisker))
    });
    drop(heeds);
    let missing = answers.iter().filter(|answer| answer.is_none()).count();
    if missing > 0 {
        warn(&format!("interrupted: {missing} of {all} rows are missing"));
    }
    let (mut rows, mut warnings, mut faults) = (Vec::new(), Vec::new(), 0);
    for ((line, cells, _, whisker), answer) in posed.into_iter().zip(answers) {
        // Rows that an interrupt left out are missing, and the others say so.
        let Some(answer) = answer else { continue };
        // A row that cannot be solved must not cost the others.
        let bends = match answer {
            Ok(bends) if bends.is_empty() => {
                warnings.push(format!("{line}: no equilibrium: {}", given.why_none()));
                bends
            }
            Ok(bends) => bends,
            Err(error) => {
                faults += 1;
                warnings.push(format!("{line}: {error}"));
                Vec::new()
            }
        };
        rows.push(Row { line, cells, whisker, bends });
    }
    if let (true, Some(first)) = (faults == all, warnings.first()) {
        return Err(Error::data(format!("no row of the batch makes sense; the first: line {first}")));
    }
    Ok(Solved { headers, rows, missing, warnings })
}

/// What one row says, on top of the options and the robot.
fn row<'a>(cell: impl Fn(&str) -> Option<&'a str>, known: &Known, whisker: &Whisker) -> Result<(Known, Whisker)> {
    let number = |name: &str, dimension: Dimension| match cell(name) {
        None | Some("") => Ok(None),
        Some(text) => match quantity(text, dimension) {
            Ok(value) if value.is_finite() || name == "k_base" => Ok(Some(value)),
            _ => Err(Error::data(name).value(text).allowed("a finite number in SI units, or with its unit")),
        },
    };
    let known = Known {
        load: load(cell("load"), number("beta", Dimension::Angle)?, known.load)?,
        force: number("F", Dimension::Force)?.or(known.force),
        s_a: number("s_a", Dimension::Length)?.or(known.s_a),
        x: number("x", Dimension::Length)?.or(known.x),
        y: number("y", Dimension::Length)?.or(known.y),
        moment: number("M0", Dimension::Moment)?.or(known.moment),
    };
    Ok((known, row_whisker(number, whisker)?))
}

/// The whisker of a row: the robot's, with what the columns change.
fn row_whisker(number: impl Fn(&str, Dimension) -> Result<Option<f64>>, whisker: &Whisker) -> Result<Whisker> {
    let (length, rigidity) = (number("L", Dimension::Length)?, number("EI", Dimension::FlexuralRigidity)?);
    let tip_ratio = number("r_tip", Dimension::Ratio)?;
    let wires = [("L", length), ("EI", rigidity), ("r_tip", tip_ratio)];
    if let ([_, ..], Some((name, Some(value)))) =
        (whisker.stretches.as_slice(), wires.into_iter().find(|(_, value)| value.is_some()))
    {
        return Err(Error::data(name)
            .value(value)
            .allowed("empty for a whisker of several segments")
            .remedy("drop the column, or give a robot without segments"));
    }
    let mut curvature_rise = whisker.curvature_rise;
    for (i, term) in curvature_rise.iter_mut().enumerate() {
        // Their unit is 1/m², 1/m³, …; only bare numbers have one.
        *term = number(&format!("kappa{}", i + 1), Dimension::Ratio)?.unwrap_or(*term);
    }
    Ok(Whisker {
        length: length.unwrap_or(whisker.length),
        flexural_rigidity: rigidity.unwrap_or(whisker.flexural_rigidity),
        tip_ratio: tip_ratio.unwrap_or(whisker.tip_ratio),
        curvature: number("kappa0", Dimension::Curvature)?.unwrap_or(whisker.curvature),
        curvature_rise,
        base_stiffness: number("k_base", Dimension::Stiffness)?.unwrap_or(whisker.base_stiffness),
        ..*whisker
    })
}

/// The load of a row: its word, its tilt, or the option.
fn load(word: Option<&str>, beta: Option<f64>, option: Load) -> Result<Load> {
    let option = match (option, beta) {
        (Load::Tilted(_), Some(beta)) => Load::Tilted(beta),
        _ => option,
    };
    match (word, option) {
        (None | Some(""), _) => Ok(option),
        (Some("normal"), _) => Ok(Load::Normal),
        (Some("vertical"), _) => Ok(Load::Vertical),
        (Some("tilted"), Load::Tilted(beta)) => Ok(Load::Tilted(beta)),
        (Some("tilted"), _) => beta
            .map(Load::Tilted)
            .ok_or_else(|| Error::data("beta is missing").remedy("a tilted load needs the column beta (rad)")),
        (Some(other), _) => Err(Error::data("load").value(other).allowed("normal, vertical, tilted")),
    }
}

/// The input columns, then what was found; one line for each solution, and one for each row without any.
fn table(solved: &Solved, given: Given) -> Result<String> {
    let appended: &[&str] = match given {
        Given::Force => &["phi_a", "x", "y", "M0"],
        Given::Moment => &["phi_a", "x", "y", "M0", "F"],
        Given::Point => &["phi_a", "x", "y", "M0", "F", "s_a"],
        Given::Tip => &["phi_a", "x", "y", "M0", "F", "s_a", "beta", "F_x", "F_y"],
    };
    let mut writer = csv::Writer::from_writer(Vec::new());
    let mut write = |cells: &csv::StringRecord, more: Vec<String>| {
        let row = cells.iter().map(String::from).chain(more);
        writer.write_record(row).map_err(|e| Error::data(format!("beam.csv: {e}")))
    };
    write(&solved.headers, appended.iter().map(|&name| name.into()).collect())?;
    for row in &solved.rows {
        if row.bends.is_empty() {
            write(&row.cells, vec![String::new(); appended.len()])?;
        }
        for b in &row.bends {
            let vector = b.force_vector();
            let contact = [b.phi_a, b.contact.x, b.contact.y, b.moment];
            let values = [&contact[..], &[b.force, b.s_a, b.beta, vector.x, vector.y]].concat();
            write(&row.cells, values[..appended.len()].iter().map(|v| format!("{v:?}")).collect())?;
        }
    }
    text_of(writer)
}

fn as_json(solved: &Solved) -> serde_json::Value {
    let row = |row: &Row| {
        let solutions: Vec<_> = row.bends.iter().map(|b| solution(b, &row.whisker)).collect();
        json!({ "line": row.line, "solutions": solutions })
    };
    let mut answer = json!({ "rows": solved.rows.iter().map(row).collect::<Vec<_>>() });
    if solved.missing > 0 {
        answer["interrupted"] = true.into();
    }
    answer
}

fn summary(solved: &Solved) -> String {
    let without = solved.rows.iter().filter(|row| row.bends.is_empty()).count();
    let solutions: usize = solved.rows.iter().map(|row| row.bends.len()).sum();
    let row = |count: usize| counted(count, "row", "rows");
    let solutions = counted(solutions, "solution", "solutions");
    format!("{}: {solutions}, {} without one\n", row(solved.rows.len()), row(without))
}

#[cfg(test)]
mod tests {
    use super::super::input::Known;
    use super::{Given, Solved, solve, table};
    use vibrissa::beam::{Load, Whisker, force_mode};

    fn solved(text: &str, given: Given) -> vibrissa::Result<Solved> {
        solve(text, given, &Known::default(), &Whisker::default())
    }

    #[test]
    fn columns_are_repeated_and_answers_appended() {
        let text = "case,F,s_a,load,beta,note\na,0.1,0.05,tilted,0.3,x\nb,-0.1,0.05,normal,,\"y,z\"\n";
        let out = table(&solved(text, Given::Force).unwrap(), Given::Force).unwrap();
        let lines: Vec<&str> = out.lines().collect();
        assert_eq!(lines.len(), 3);
        assert_eq!(lines[0], "case,F,s_a,load,beta,note,phi_a,x,y,M0");
        assert!(lines[2].starts_with("b,-0.1,0.05,normal,,\"y,z\",-"));
        let bend = force_mode(&Whisker::default(), 0.1, 0.05, Load::Tilted(0.3)).unwrap().remove(0);
        let numbers: Vec<f64> = lines[1].split(',').skip(6).map(|c| c.parse().unwrap()).collect();
        assert_eq!(numbers, [bend.phi_a, bend.contact.x, bend.contact.y, bend.moment]);
    }

    #[test]
    fn every_branch_is_a_row() {
        let text = "M0,s_a\n0.01,0.05\n0.1,0.05\n";
        let found = solved(text, Given::Moment).unwrap();
        assert_eq!(found.rows.iter().map(|r| r.bends.len()).collect::<Vec<_>>(), [2, 0]);
        assert_eq!(found.warnings.len(), 1);
        assert!(found.warnings[0].starts_with("3: no equilibrium"));
        let out = table(&found, Given::Moment).unwrap();
        assert_eq!(out.lines().count(), 4);
        assert_eq!(out.lines().last(), Some("0.1,0.05,,,,,"));
    }

    #[test]
    fn a_row_without_sense_does_not_cost_the_others() {
        let text = "F,s_a,r_tip,k_base\n0.1,0.05,0,inf\n0.1,0.05,1,inf\n0.1,0.09,1,inf\n";
        let found = solved(text, Given::Force).unwrap();
        assert_eq!(found.rows.iter().map(|r| r.bends.len()).collect::<Vec<_>>(), [0, 1, 0]);
        assert!(found.warnings[0].starts_with("2: tip_ratio: 0 "), "{:?}", found.warnings);
        assert!(found.warnings[1].starts_with("4: s_a: 0.09"), "{:?}", found.warnings);
        assert_eq!(found.warnings.len(), 2);
    }

    #[test]
    fn broken_tables_name_the_line() {
        for (text, line, word) in [
            ("F,s_a\n0.1,0.05\n0.1,NaN\n", 3, "s_a: NaN"),
            ("F,s_a\nten,0.05\n", 2, "F: ten"),
            ("F,s_a\n0.1,0.05\n0.1\n", 3, "broken table"),
            ("F,s_a,load\n0.1,0.05,diagonal\n", 2, "load: diagonal"),
            ("F,s_a,load\n0.1,0.05,tilted\n", 2, "beta is missing"),
            ("F,s_a\ninf,0.05\n", 2, "F: inf"),
        ] {
            let error = solved(text, Given::Force).err().unwrap();
            assert!(error.is_data() && error.line() == Some(line), "{error}");
            assert!(error.to_string().contains(word), "{error}");
        }
        assert!(solved("F,s_a\n", Given::Force).is_err());
        assert!(solved("", Given::Force).is_err());
    }
}
