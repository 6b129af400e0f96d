//! What the times of a source are made from.

use crate::Result;
use crate::config::{RATE, RATE_OF_TWO};
use crate::decode::WireFormat;
use crate::timing::TimeBase;
use vibrissa_io::Dimension;
use vibrissa_io::text::did_you_mean;
use vibrissa_io::toml_section::{Allowed, Section};

const TIMES: [&str; 4] = ["stamps", "count", "arrival", "own"];
pub(super) const RATES: Allowed = Allowed { holds: |v| (0.1..=1e5).contains(&v), text: "0.1 to 100000 Hz", remedy: "" };

/// What the times of a source are made from: what is asked for, else what its lines have.
pub(super) fn time(
    entry: &Section<'_>,
    format: WireFormat,
    columns: Option<&[String]>,
    whole: bool,
) -> Result<TimeBase> {
    let rate = entry.number("rate", Dimension::Frequency, &RATES)?;
    let stamped = match format {
        WireFormat::Serial | WireFormat::Serial2 => false,
        WireFormat::Plotter => columns.is_some_and(|names| names.iter().any(|name| is_time(name.rsplit(':').next()))),
        WireFormat::Csv => columns.is_none_or(|names| names.iter().any(|name| is_time(Some(name)))),
        WireFormat::Ratatouille | WireFormat::Openwhisker | WireFormat::Tum | WireFormat::Head => true,
    };
    let nominal = match format {
        WireFormat::Serial => Some(RATE),
        WireFormat::Serial2 => Some(RATE_OF_TWO),
        _ => None,
    };
    let word = entry.text("time")?;
    let fault = |what: &str| entry.source.fault(&entry.span_of("time"), what);
    let rate = rate.or(nominal);
    match word {
        None if stamped && whole => Ok(TimeBase::Own),
        None if stamped => Ok(TimeBase::Stamps),
        None => Ok(rate.map_or(TimeBase::Arrival, TimeBase::Counted)),
        Some("arrival") => Ok(TimeBase::Arrival),
        Some("count") => rate.map(TimeBase::Counted).ok_or_else(|| {
            fault("a count needs its rate").remedy("add rate = \"300 Hz\", what the firmware is set to")
        }),
        Some(word @ ("stamps" | "own")) if !stamped => {
            Err(fault("the lines of this source have no stamps").value(format!("\"{word}\"")).allowed("count, arrival"))
        }
        Some("stamps") => Ok(TimeBase::Stamps),
        Some("own") => Ok(TimeBase::Own),
        Some(word) => Err(fault("unknown time")
            .value(format!("\"{word}\""))
            .allowed(TIMES.join(", "))
            .remedy(did_you_mean(word, &TIMES))),
    }
}

fn is_time(name: Option<&str>) -> bool {
    matches!(name.map(str::trim), Some("t" | "t_ms" | "t_us"))
}
