//! Files of parameters as ROS 2 writes them.
//!
//! ```yaml
//! /**:                      # every node; or a node's name, with its namespace or without it
//!   ros__parameters:
//!     map: arena.svg
//!     initial_pose: {x: 0.2, y: 0.1, yaw: 0.0}
//! ```

use crate::config::{PARAMETERS_BYTES, PARAMETERS_DEPTH};
use granit_parser::{Event, Parser};
use std::path::Path;
use vibrissa_core::{Error, Result};
use vibrissa_io::text::read_text;

/// The key under which a node's parameters stand.
const PARAMETERS: &str = "ros__parameters";

/// One parameter of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// The node that it is for, as written: words between slashes, `*` for one of them, `**` for any number.
    pub node: String,
    /// Its name; nested keys with dots between them.
    pub name: String,
    /// Its value as text; of a list its items with commas between them.
    pub value: String,
    /// Its line.
    pub line: usize,
}

impl Entry {
    /// Whether it is for a node.
    #[must_use]
    pub fn is_for(&self, namespace: &str, name: &str) -> bool {
        let words = |text: &str| text.split('/').filter(|w| !w.is_empty()).map(str::to_owned).collect::<Vec<_>>();
        let full = [words(namespace), words(name)].concat();
        let pattern = words(&self.node);
        // A name without a slash is that of a node in any namespace.
        let anywhere = !self.node.starts_with('/') && pattern.len() == 1 && full.last() == pattern.first();
        anywhere || matches(&pattern, &full)
    }
}

fn matches(pattern: &[String], words: &[String]) -> bool {
    match pattern.split_first() {
        None => words.is_empty(),
        Some((first, rest)) if first == "**" => (0..=words.len()).any(|passed| matches(rest, &words[passed..])),
        Some((first, rest)) => {
            words.split_first().is_some_and(|(w, more)| (first == "*" || first == w) && matches(rest, more))
        }
    }
}

/// The parameters of a file, in order.
///
/// # Errors
///
/// A file that cannot be read, is no YAML, or has no `ros__parameters`.
pub fn read(path: &Path) -> Result<Vec<Entry>> {
    let text = read_text(path, "parameters", PARAMETERS_BYTES)?;
    entries(&text).map_err(|(line, why)| {
        Error::data("not a file of ROS 2 parameters")
            .in_file(path)
            .at_line(line.max(1))
            .value(why)
            .remedy("it looks like this: /**: {ros__parameters: {map: arena.svg}}")
    })
}

/// The entries of a text; what is wrong with its line.
fn entries(text: &str) -> core::result::Result<Vec<Entry>, (usize, String)> {
    let mut found = Vec::new();
    // The keys down to here; none while a key is due, or inside a list its items so far.
    let mut keys: Vec<Option<String>> = Vec::new();
    let mut list: Option<(Vec<String>, usize)> = None;
    let mut last = 1;
    for event in Parser::new_from_str(text) {
        let (event, span) = event.map_err(|e| (e.marker().line(), e.info()))?;
        let line = span.start.line();
        last = line.max(last);
        let fault = |why: &str| (line, why.to_owned());
        match event {
            Event::MappingStart(..) if list.is_some() => return Err(fault("a list holds keys")),
            Event::MappingStart(..) if keys.len() >= PARAMETERS_DEPTH => return Err(fault("it is nested too deeply")),
            Event::MappingStart(..) if keys.last().is_some_and(Option::is_none) => {
                return Err(fault("a key is no text"));
            }
            Event::MappingStart(..) => keys.push(None),
            Event::MappingEnd => {
                keys.pop();
                keys.last_mut().map(Option::take);
            }
            Event::SequenceStart(..) if list.is_some() || !keys.last().is_some_and(Option::is_some) => {
                return Err(fault("a list stands where none may be"));
            }
            Event::SequenceStart(..) => list = Some((Vec::new(), line)),
            Event::SequenceEnd => {
                if let Some((items, line)) = list.take() {
                    found.extend(entry(&keys, items.join(","), line));
                }
                keys.last_mut().map(Option::take);
            }
            Event::Scalar(text, ..) => match (&mut list, keys.last_mut()) {
                (Some((items, _)), _) => items.push(text.into_owned()),
                (None, Some(key @ None)) => *key = Some(text.into_owned()),
                (None, Some(Some(_))) => {
                    found.extend(entry(&keys, text.into_owned(), line));
                    keys.last_mut().map(Option::take);
                }
                (None, None) => return Err(fault("it holds no keys")),
            },
            Event::Alias(_) => return Err(fault("an alias: write its value here")),
            _ => {}
        }
    }
    match found.is_empty() {
        true => Err((last, format!("nothing stands under {PARAMETERS}"))),
        false => Ok(found),
    }
}

/// The parameter that these keys name; none outside `ros__parameters`.
fn entry(keys: &[Option<String>], value: String, line: usize) -> Option<Entry> {
    let keys: Vec<&str> = keys.iter().map(|key| key.as_deref()).collect::<Option<_>>()?;
    let at = keys.iter().position(|key| *key == PARAMETERS)?;
    let (node, name) = (keys[..at].join("/"), keys[at + 1..].join("."));
    (!name.is_empty()).then_some(Entry { node, name, value, line })
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]
mod tests {
    use super::{Entry, entries};

    #[test]
    fn nested_keys_lists_and_nodes() {
        let text = "# comment\n/robot:\n  vibrissa:\n    ros__parameters:\n      a: 'x y'\n      b: {c: {d: 1.5}}\n      \
                    list:\n      - one\n      - two\n      empty: []\nbeside: 3\n";
        let found = entries(text).unwrap();
        let told: Vec<(&str, &str, usize)> =
            found.iter().map(|e| (e.name.as_str(), e.value.as_str(), e.line)).collect();
        assert_eq!(told, [("a", "x y", 5), ("b.c.d", "1.5", 6), ("list", "one,two", 8), ("empty", "", 10)]);
        assert!(found.iter().all(|e| e.node == "/robot/vibrissa"));
    }

    #[test]
    fn nodes_are_named_with_wildcards() {
        let is_for = |node: &str, namespace: &str, name: &str| {
            Entry { node: node.into(), name: "a".into(), value: String::new(), line: 1 }.is_for(namespace, name)
        };
        for node in ["/**", "vibrissa", "/robot/vibrissa", "/*/vibrissa", "/**/vibrissa", "robot/vibrissa"] {
            assert!(is_for(node, "/robot", "vibrissa"), "{node}");
        }
        for node in ["/vibrissa", "amcl", "/*", "/robot", "/*/*/vibrissa"] {
            assert!(!is_for(node, "/robot", "vibrissa"), "{node}");
        }
        assert!(is_for("/vibrissa", "/", "vibrissa") && is_for("/*", "/", "vibrissa"));
    }

    #[test]
    fn whatever_stands_there_nothing_panics() {
        for text in [
            "[",
            "a: [b: c]",
            "a: [[1]]",
            "? {a: b}\n: c",
            "a: &x {ros__parameters: {b: 1}}\nc: *x",
            "- a",
            "x",
            "a: b: c",
        ] {
            assert!(entries(text).is_err(), "{text}");
        }
        let deep = "{a: ".repeat(2000);
        assert!(entries(&deep).is_err());
    }
}
