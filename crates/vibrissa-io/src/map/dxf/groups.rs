//! The lines of a DXF text: pairs of a code and a value, in sections.

use crate::config::budgets::MOST_GROUPS;
use crate::text::beyond;
use crate::{Error, Result};
use core::str::FromStr;

/// A code and its value.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group<'a> {
    pub(super) code: i32,
    pub(super) value: &'a str,
    /// The value's line.
    pub(super) line: usize,
}

/// One drawn thing: its kind, and the groups up to the next one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entity<'a> {
    pub(super) kind: &'a str,
    pub(super) line: usize,
    pub(super) groups: &'a [Group<'a>],
}

/// Every group of the text; comments are left out.
pub(super) fn groups(text: &str) -> Result<Vec<Group<'_>>> {
    let mut lines = text.lines().enumerate().map(|(i, line)| (i + 1, line.trim()));
    let mut found = Vec::new();
    while let Some((line, code)) = lines.next() {
        let Ok(number) = code.parse() else {
            if code.is_empty() && lines.all(|(_, rest)| rest.is_empty()) {
                break;
            }
            return Err(Error::data("not DXF: a group code is due here")
                .at_line(line)
                .value(excerpt(code))
                .allowed("a whole number, with its value in the next line"));
        };
        let Some((line, value)) = lines.next() else { return Err(cut_off(line)) };
        if number == 0 && value == "EOF" {
            return Ok(found);
        }
        if found.len() >= MOST_GROUPS {
            let remedy = "export the layers of the map alone";
            return Err(beyond("the drawing has too many groups", found.len() + 1, MOST_GROUPS, remedy).at_line(line));
        }
        if number != 999 {
            found.push(Group { code: number, value, line });
        }
    }
    Err(cut_off(found.last().map_or(1, |group| group.line)))
}

/// The beginning of what stands in the file.
pub(super) fn excerpt(text: &str) -> String {
    let short: String = text.chars().filter(|c| !c.is_control()).take(40).collect();
    format!("\"{short}\"")
}

fn cut_off(line: usize) -> Error {
    Error::data("the drawing ends too early, without EOF").at_line(line).remedy("was the file cut off? export it again")
}

/// The groups of the section `name`; none if there is no such section.
pub(super) fn section<'a>(groups: &'a [Group<'a>], name: &str) -> &'a [Group<'a>] {
    let opens = |pair: &[Group<'_>]| pair[0].code == 0 && pair[0].value == "SECTION" && pair[1].value == name;
    let Some(start) = groups.windows(2).position(opens) else { return &[] };
    let inside = &groups[start + 2..];
    let end = inside.iter().position(|group| group.code == 0 && group.value == "ENDSEC");
    &inside[..end.unwrap_or(inside.len())]
}

/// The entities of a section.
pub(super) fn entities<'a>(section: &'a [Group<'a>]) -> Vec<Entity<'a>> {
    let starts: Vec<usize> = (0..section.len()).filter(|&i| section[i].code == 0).collect();
    let ends = starts.iter().skip(1).copied().chain([section.len()]);
    let one = |(&start, end): (&usize, usize)| Entity {
        kind: section[start].value,
        line: section[start].line,
        groups: &section[start + 1..end],
    };
    starts.iter().zip(ends).map(one).collect()
}

impl<'a> Entity<'a> {
    /// The first value of a code.
    pub(super) fn word(&self, code: i32) -> Option<&'a str> {
        self.groups.iter().find(|group| group.code == code).map(|group| group.value)
    }

    /// The layer's name.
    pub(super) fn layer(&self) -> &'a str {
        self.word(8).unwrap_or("0")
    }

    /// The first number of a code, if there is one.
    pub(super) fn number(&self, code: i32) -> Result<Option<f64>> {
        self.groups.iter().find(|group| group.code == code).map(number).transpose()
    }

    /// The number of a code that must be there.
    pub(super) fn due(&self, code: i32) -> Result<f64> {
        let missing = || Error::data(format!("the group {code} is missing")).at_line(self.line);
        self.number(code)?.ok_or_else(missing)
    }

    /// Bits of the flags in group 70.
    pub(super) fn flags(&self) -> Result<u32> {
        let word = self.groups.iter().find(|group| group.code == 70);
        word.map_or(Ok(0), |group| parsed(group, "a whole number from 0 on"))
    }

    /// Every number of a code.
    pub(super) fn numbers(&self, code: i32) -> Result<Vec<f64>> {
        self.groups.iter().filter(|group| group.code == code).map(number).collect()
    }
}

/// The finite number in a group.
pub(super) fn number(group: &Group<'_>) -> Result<f64> {
    let number: f64 = parsed(group, "a number")?;
    if number.is_finite() { Ok(number) } else { Err(unreadable(group, "a finite number")) }
}

/// What a group says, in its type.
pub(super) fn parsed<T: FromStr>(group: &Group<'_>, due: &str) -> Result<T> {
    group.value.parse().map_err(|_| unreadable(group, due))
}

fn unreadable(group: &Group<'_>, due: &str) -> Error {
    Error::data(format!("the group {} cannot be read", group.code))
        .at_line(group.line)
        .value(excerpt(group.value))
        .allowed(due)
}
