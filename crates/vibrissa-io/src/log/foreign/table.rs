//! Our own columns without odometry: what calibrations are made from.

use super::lines::{lines, number};
use super::{Format, Recording, Series};

/// A header line of column names, then numbers in SI units (or counts); `t` becomes the time, rows that cannot be read
/// are dropped.
pub(super) fn read(bytes: &[u8]) -> Recording {
    let mut recording = Recording::new(Format::Csv, &[]);
    let mut rows = lines(bytes).filter(|line| !line.text.is_empty() && !line.text.starts_with('#'));
    let Some(header) = rows.next() else { return recording };
    let names: Vec<String> = header.text.split(',').map(|name| name.trim().to_owned()).collect();
    let repeated = names.iter().enumerate().any(|(i, name)| names[..i].contains(name));
    if repeated || names.iter().any(|name| name.is_empty() || number(name).is_some()) {
        recording.repairs.lines_dropped = 1 + rows.count();
        return recording;
    }
    let clock = names.iter().position(|name| name == "t");
    let columns = names.iter().enumerate().filter(|(i, _)| Some(*i) != clock);
    recording.series =
        columns.map(|(_, name)| Series { name: name.clone(), unit: unit(name), values: Vec::new() }).collect();
    for line in rows {
        let values: Option<Vec<f64>> = line.text.split(',').map(number).collect();
        let Some(mut values) = values.filter(|values| values.len() == names.len()) else {
            recording.repairs.drop_line(&line);
            continue;
        };
        if let Some(clock) = clock {
            let t = values.remove(clock);
            if recording.t.last().is_some_and(|last| t <= *last) {
                recording.repairs.out_of_order += 1;
                continue;
            }
            recording.t.push(t);
        }
        recording.push(line.number, values);
    }
    recording
}

/// The unit that a column's name stands for; empty for columns of the user's own.
fn unit(name: &str) -> &'static str {
    match name.rsplit('.').next().unwrap_or(name) {
        "x" | "y" | "z" | "dist" | "bend" => "m",
        "theta" | "slope" | "heading" => "rad",
        "moment" | "across" => "N m",
        "force" => "N",
        "bx" | "by" | "bz" => "T",
        "ax" | "ay" | "az" => "counts",
        _ => "",
    }
}
