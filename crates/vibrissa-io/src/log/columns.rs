//! The header of a log: which column holds what.

use crate::config::budgets::{LONGEST_NAME, MOST_COLUMNS};
use crate::flow::sensor_log::{Channel, Quantity};
use crate::text::{beyond, did_you_mean, listed, short};
use crate::{Error, Result};

/// Where each part of a row stands.
#[derive(Clone, Debug)]
pub(super) struct Columns {
    /// The fields of `t`, `x`, `y`, `theta`.
    pub(super) odometry: [usize; 4],
    pub(super) heading: Option<usize>,
    pub(super) channels: Vec<Channel>,
    /// The field of each channel.
    pub(super) readings: Vec<usize>,
    /// The names as written, for messages.
    pub(super) names: Vec<String>,
    pub(super) warnings: Vec<String>,
}

pub(super) const ODOMETRY: [&str; 4] = ["t", "x", "y", "theta"];

impl Columns {
    pub(super) fn new(names: Vec<String>) -> Result<Self> {
        if names.first().is_some_and(|name| name.parse::<f64>().is_ok()) {
            return Err(Error::data("the log has no header line, it starts with a number")
                .value(format!("\"{}\"", short(&names[0])))
                .remedy("put the column names on the first line: t,x,y,theta,moment"));
        }
        within_budget(&names)?;
        no_repeats(&names)?;
        let mut columns = Self {
            odometry: [0; 4],
            heading: None,
            channels: Vec::new(),
            readings: Vec::new(),
            names: names.clone(),
            warnings: Vec::new(),
        };
        let mut unknown = Vec::new();
        for (index, name) in names.iter().enumerate() {
            if name == "heading" {
                columns.heading = Some(index);
            } else if let Some(channel) = channel(name) {
                columns.channels.push(channel);
                columns.readings.push(index);
            } else if !ODOMETRY.contains(&name.as_str()) {
                unknown.push(name.as_str());
            }
        }
        for (place, word) in columns.odometry.iter_mut().zip(ODOMETRY) {
            *place = names.iter().position(|n| n == word).ok_or_else(|| missing(word, &names, &unknown))?;
        }
        if columns.channels.is_empty() {
            return Err(missing("moment", &names, &unknown));
        }
        columns.warnings = warnings(&columns.channels, &unknown);
        Ok(columns)
    }
}

/// The names without a byte order mark and without their units, which have to be SI, as in `t [s]` or `moment (N m)`.
pub(super) fn without_units(names: Vec<String>) -> Result<Vec<String>> {
    names.into_iter().map(|name| without_unit(name.trim_start_matches('\u{feff}'))).collect()
}

fn without_unit(name: &str) -> Result<String> {
    let Some((word, unit)) = name.split_once(['[', '(']) else { return Ok(name.to_owned()) };
    let (word, unit) = (word.trim(), unit.trim_end_matches([']', ')']));
    let compact: String = unit.chars().filter(|c| !matches!(c, ' ' | '*' | '·' | '.')).collect();
    let due = unit_of(word);
    match due {
        // A name that is not ours is ignored anyway.
        None => Ok(name.to_owned()),
        Some(due) if compact == due.replace(' ', "") => Ok(word.to_owned()),
        Some(due) => Err(Error::data("a column in another unit")
            .value(format!("\"{name}\""))
            .allowed(format!("`{word}`, in {due}"))
            .remedy(format!("convert the column to {due} and name it `{word}`"))),
    }
}

/// The unit of a column; none of one that is not ours.
fn unit_of(name: &str) -> Option<&'static str> {
    match name {
        "t" => Some("s"),
        "x" | "y" => Some("m"),
        "theta" | "heading" => Some("rad"),
        _ => channel(name).map(|channel| match channel.quantity {
            Quantity::Moment | Quantity::Across => "N m",
            Quantity::FluxX | Quantity::FluxY | Quantity::FluxZ => "T",
            Quantity::CountX | Quantity::CountY | Quantity::CountZ => "counts",
            Quantity::Force => "N",
            Quantity::Slope => "rad",
            Quantity::StripLo | Quantity::StripHi => "m",
        }),
    }
}

/// `moment`, `left.moment` and the like.
pub(super) fn channel(name: &str) -> Option<Channel> {
    let (whisker, word) = name.rsplit_once('.').unwrap_or(("", name));
    let quantity = Quantity::ALL.into_iter().find(|q| q.word() == word)?;
    (!whisker.is_empty() || !name.starts_with('.')).then(|| Channel { whisker: whisker.to_owned(), quantity })
}

fn within_budget(names: &[String]) -> Result<()> {
    if names.len() > MOST_COLUMNS {
        let remedy = "leave out the columns that are not used";
        return Err(beyond("the log has too many columns", names.len(), MOST_COLUMNS, remedy));
    }
    let Some((index, name)) = names.iter().enumerate().find(|(_, name)| name.len() > LONGEST_NAME) else {
        return Ok(());
    };
    let value = format!("{} bytes: {}", name.len(), short(name));
    Err(beyond("the name of a column is too long", value, LONGEST_NAME, "give it a short name")
        .about(&format!("column {}", index + 1)))
}

fn no_repeats(names: &[String]) -> Result<()> {
    let repeated = names.iter().enumerate().find(|(i, name)| names[..*i].contains(name));
    match repeated {
        Some((index, name)) => Err(Error::data("two columns have the same name")
            .value(format!("\"{name}\" (columns {} and {})", 1 + first(names, name), index + 1))
            .remedy("rename one; several whiskers are told apart as NAME.moment")),
        None => Ok(()),
    }
}

fn first(names: &[String], name: &str) -> usize {
    names.iter().position(|n| n == name).unwrap_or(0)
}

fn missing(word: &str, names: &[String], unknown: &[&str]) -> Error {
    let what = match word {
        "moment" => "the log has no column of readings".to_owned(),
        _ => format!("the log has no column `{word}`"),
    };
    let error = Error::data(what)
        .value(format!("its columns are {}", listed(names)))
        .allowed("t,x,y,theta and moment (or NAME.moment), in any order");
    match unknown.iter().find(|name| did_you_mean(name.rsplit('.').next().unwrap_or(name), &[word]).starts_with("did"))
    {
        Some(near) => {
            let prefix = near.rsplit_once('.').map_or(String::new(), |(whisker, _)| format!("{whisker}."));
            error.remedy(format!("is `{near}` meant to be `{prefix}{word}`? Rename it"))
        }
        None if names.len() == 1 => error.remedy("separate the columns by commas"),
        None => error.remedy(format!("add the column `{word}`")),
    }
}

/// Most columns that are warned of one by one.
const TOLD: usize = 8;

fn warnings(channels: &[Channel], unknown: &[&str]) -> Vec<String> {
    let known: Vec<&str> = ODOMETRY.into_iter().chain(["heading"]).chain(Quantity::ALL.map(Quantity::word)).collect();
    let ignored = |name: &&str| {
        let hint = did_you_mean(name.rsplit('.').next().unwrap_or(name), &known);
        if hint.starts_with("did") {
            format!("the column `{}` is ignored: {hint}", short(name))
        } else {
            format!("the column `{}` is ignored: not a known quantity", short(name))
        }
    };
    let mut warnings: Vec<String> = unknown.iter().take(TOLD).map(ignored).collect();
    if unknown.len() > TOLD {
        warnings.push(format!("{} more columns are ignored", unknown.len() - TOLD));
    }
    let named = |wanted: &dyn Fn(&Channel) -> bool| {
        listed(&channels.iter().filter(|c| wanted(c)).map(Channel::column).collect::<Vec<_>>())
    };
    let strips = named(&is_strip);
    if !strips.is_empty() {
        warnings.push(format!("used by `contact --filter` only: {strips}"));
    }
    let across = named(&|c| c.quantity == Quantity::Across);
    if !across.is_empty() {
        warnings.push(format!("used by `contact --space` only: {across}"));
    }
    let unused = named(&|c| !is_strip(c) && !is_used(c, channels));
    if !unused.is_empty() {
        warnings.push(format!("not used, since there are moments: {unused}"));
    }
    let sharp: Vec<String> = channels.iter().filter(|c| is_probabilistic(c)).map(Channel::column).collect();
    if !sharp.is_empty() {
        warnings.push(format!("used by the probabilistic method and `contact --filter` only: {}", listed(&sharp)));
    }
    warnings
}

fn is_probabilistic(channel: &Channel) -> bool {
    matches!(channel.quantity, Quantity::Force | Quantity::Slope)
}

fn is_strip(channel: &Channel) -> bool {
    matches!(channel.quantity, Quantity::StripLo | Quantity::StripHi)
}

/// Moments, forces and slopes are used as they are, flux and counts through a calibration where there is no moment.
fn is_used(channel: &Channel, channels: &[Channel]) -> bool {
    let has_moment = || channels.iter().any(|c| c.quantity == Quantity::Moment && c.whisker == channel.whisker);
    match channel.quantity {
        Quantity::Moment | Quantity::Across => true,
        Quantity::Force | Quantity::Slope => true,
        Quantity::StripLo | Quantity::StripHi => true,
        _ => !has_moment(),
    }
}
