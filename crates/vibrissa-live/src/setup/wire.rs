//! Where a source's bytes come from.

use super::columns::said;
use crate::config::BAUD;
use crate::source::{Playback, Played, Ros2Message, Wire};
use crate::{Error, Result};
use toml::de::DeValue;
use vibrissa_io::Dimension;
use vibrissa_io::text::did_you_mean;
use vibrissa_io::toml_section::{Allowed, Section, show};

/// The keys of which a source has one.
pub(super) const WIRES: [&str; 8] = ["serial", "tcp", "udp", "unix", "pipe", "ros2", "recording", "simulated"];
/// What hardware and drivers take.
const BAUDS: core::ops::RangeInclusive<u64> = 50..=12_000_000;
const SPEEDS: Allowed = Allowed {
    holds: |v| (0.01..=1000.0).contains(&v),
    text: "0.01 to 1000",
    remedy: "1 is its own speed; pipe = \"log.csv\" reads a file as fast as it goes",
};

pub(super) fn wire(entry: &Section<'_>) -> Result<Wire> {
    let given: Vec<&str> = WIRES.into_iter().filter(|key| entry.get(key).is_some()).collect();
    let [key] = given[..] else {
        return Err(entry
            .source
            .fault(&entry.span, "a source has one wire")
            .value(if given.is_empty() { "none of them".to_owned() } else { given.join(", ") })
            .allowed(WIRES.join(", "))
            .remedy("such as serial = \"/dev/ttyACM0\", udp = \"0.0.0.0:9000\" or pipe = \"-\""));
    };
    let text = entry.text(key)?.unwrap_or_default();
    let baud = baud(entry, key)?;
    let played = |kind| -> Result<Wire> {
        let speed = entry.number("speed", Dimension::Ratio, &SPEEDS)?.unwrap_or(1.0);
        Ok(Wire::Played(Playback::new(kind, text, speed)))
    };
    let wire = match key {
        "serial" => Wire::Serial { port: text.into(), baud },
        "tcp" => Wire::Tcp(address(entry, key, text)?),
        "udp" => Wire::Udp(address(entry, key, text)?),
        "unix" => Wire::Unix(text.into()),
        "ros2" => Wire::Ros2 { topic: topic(entry, text)?, message: message(entry)? },
        "recording" => played(Played::Log)?,
        "simulated" => played(Played::Scenario)?,
        _ => Wire::Pipe(text.into()),
    };
    only_of(entry, "speed", matches!(wire, Wire::Played(_)), "only a recording or a simulated robot has a speed")?;
    only_of(entry, "message", matches!(wire, Wire::Ros2 { .. }), "only topics of ROS 2 have messages")?;
    let says_itself = |what: &str| format!("{what} says itself what it holds");
    match &wire {
        Wire::Played(_) => ["format", "columns", "checksums", "rate"]
            .iter()
            .try_for_each(|key| only_of(entry, key, false, &says_itself("a log")))?,
        Wire::Ros2 { message, .. } => {
            let given = if *message == Ros2Message::Array {
                &["format", "checksums"][..]
            } else {
                &["format", "checksums", "columns"]
            };
            given.iter().try_for_each(|key| only_of(entry, key, false, &says_itself("a message of ROS 2")))?;
        }
        _ => {}
    }
    Ok(wire)
}

/// Refuses a key that this wire does not have.
fn only_of(entry: &Section<'_>, key: &str, has_it: bool, what: &str) -> Result<()> {
    match entry.get(key) {
        Some(value) if !has_it => {
            let shown = format!("{key} = {}", show(value.get_ref()));
            Err(entry.source.fault(&value.span(), what).value(shown).remedy("leave it out"))
        }
        _ => Ok(()),
    }
}

fn baud(entry: &Section<'_>, key: &str) -> Result<u32> {
    let Some(value) = entry.get("baud") else { return Ok(BAUD) };
    let fault = |what: String| entry.source.fault(&value.span(), what).value(show(value.get_ref()));
    if key != "serial" {
        return Err(fault("only serial ports have a baud rate".to_owned()).remedy("leave it out"));
    }
    let number = match value.get_ref() {
        DeValue::Integer(i) if i.radix() == 10 => i.as_str().parse::<u64>().ok(),
        DeValue::Integer(_) => Some(0),
        _ => None,
    };
    let range = |error: Error| {
        error
            .allowed(format!("{} to {}", BAUDS.start(), BAUDS.end()))
            .remedy("use the number in the firmware's Serial.begin()")
    };
    match number {
        Some(baud) if BAUDS.contains(&baud) => Ok(baud as u32),
        Some(_) => Err(range(fault(format!("{} is out of range", entry.key("baud"))))),
        None => Err(range(fault(format!("{} must be a whole number", entry.key("baud"))))),
    }
}

fn address(entry: &Section<'_>, key: &str, text: &str) -> Result<String> {
    match text.rsplit_once(':') {
        Some((_, port)) if port.parse::<u16>().is_ok() => Ok(text.to_owned()),
        _ => Err(entry
            .source
            .fault(&entry.span_of(key), format!("{} is no address", entry.key(key)))
            .value(format!("\"{text}\""))
            .allowed("host:port, such as \"192.168.0.5:9000\"")),
    }
}

fn topic(entry: &Section<'_>, text: &str) -> Result<String> {
    let inside = text.strip_prefix('/').unwrap_or(text);
    let is_word = |part: &str| {
        part.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
            && part.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
    };
    if inside.split('/').all(is_word) {
        return Ok(text.to_owned());
    }
    Err(entry
        .source
        .fault(&entry.span_of("ros2"), "no name of a topic")
        .value(format!("\"{text}\""))
        .allowed("letters, digits and _ between slashes, such as \"/base/odom\""))
}

fn message(entry: &Section<'_>) -> Result<Ros2Message> {
    let known = Ros2Message::ALL.map(Ros2Message::as_str);
    let Some(word) = entry.text("message")? else {
        return Err(entry
            .source
            .fault(&entry.span, "a topic of ROS 2 needs the kind of its messages")
            .allowed(known.join(", "))
            .remedy("add message = \"odometry\" (nav_msgs/Odometry), or what the readings come in"));
    };
    let found = Ros2Message::ALL.into_iter().find(|message| message.as_str() == word);
    let found = found.ok_or_else(|| {
        entry
            .source
            .fault(&entry.span_of("message"), "unknown kind of message")
            .value(format!("\"{word}\""))
            .allowed(known.join(", "))
            .remedy(did_you_mean(word, &known))
    })?;
    if found == Ros2Message::Array && said(entry)?.is_none() {
        return Err(entry
            .source
            .fault(&entry.span, "an array does not say what its numbers are")
            .remedy("name them: columns = [\"left.moment\", \"right.moment\"]"));
    }
    Ok(found)
}
