//! The keys of a YAML text and their values, as far as `map_server` uses them.

use crate::config::budgets::{LONGEST_NAME, YAML_DEPTH, YAML_LIST};
use crate::text::short;
use granit_parser::{Event, Parser, ScalarStyle, ScanError, Span};
use std::collections::BTreeMap;

/// What is wrong with a text, and where.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Fault {
    /// Counted from 1.
    pub(super) line: usize,
    pub(super) why: String,
}

/// A scalar as it is written, without its quotes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Scalar {
    text: String,
    is_null: bool,
    line: usize,
}

/// The value of a key.
#[derive(Clone, Debug, PartialEq)]
enum Value {
    One(Scalar),
    List(Vec<Scalar>, usize),
}

/// The keys of a text that were asked for.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Keys(BTreeMap<&'static str, Value>);

impl Scalar {
    pub(super) fn fault(&self, why: &str) -> Fault {
        Fault { line: self.line, why: format!("{}: {why}", short(&self.text)) }
    }

    /// A finite number, or one that says that it is not.
    fn number(&self) -> Option<f64> {
        let text = self.text.trim();
        match text.trim_start_matches(['+', '-']) {
            ".nan" | ".NaN" | ".NAN" => Some(f64::NAN),
            ".inf" | ".Inf" | ".INF" => Some(f64::INFINITY.copysign(if text.starts_with('-') { -1.0 } else { 1.0 })),
            _ => text.parse().ok().filter(|number: &f64| number.is_finite()),
        }
    }

    fn told_number(&self, key: &str) -> Result<f64, Fault> {
        self.number().ok_or_else(|| self.fault(&format!("{key} is no number")))
    }
}

impl Keys {
    /// The value of a key, if it is there and not empty.
    pub(super) fn text(&self, key: &str) -> Result<Option<&str>, Fault> {
        match self.0.get(key) {
            None => Ok(None),
            Some(Value::One(scalar)) => Ok(Some(scalar.text.as_str()).filter(|_| !scalar.is_null)),
            Some(Value::List(_, line)) => Err(Fault { line: *line, why: format!("{key} is a list") }),
        }
    }

    pub(super) fn number(&self, key: &str) -> Result<Option<f64>, Fault> {
        match self.0.get(key) {
            None => Ok(None),
            Some(Value::One(scalar)) => scalar.told_number(key).map(Some),
            Some(Value::List(_, line)) => Err(Fault { line: *line, why: format!("{key} is a list") }),
        }
    }

    pub(super) fn numbers(&self, key: &str) -> Result<Option<Vec<f64>>, Fault> {
        match self.0.get(key) {
            None => Ok(None),
            Some(Value::List(scalars, _)) => {
                scalars.iter().map(|s| s.told_number(key)).collect::<Result<_, _>>().map(Some)
            }
            Some(Value::One(scalar)) => Err(scalar.fault(&format!("{key} is no list"))),
        }
    }

    /// Reads a text: one mapping, of which only the keys in `wanted` are kept.
    ///
    /// # Errors
    ///
    /// What is not YAML or not one mapping, a key that stands twice, a wanted key with anything but a scalar or a list of
    /// scalars.
    pub(super) fn read(text: &str, wanted: &[&'static str]) -> Result<Self, Fault> {
        let mut walk = Walk { parser: Parser::new_from_str(text), line: 1 };
        let mut first = walk.next()?;
        while let Event::StreamStart | Event::DocumentStart(..) = first {
            first = walk.next()?;
        }
        if !matches!(first, Event::MappingStart(..)) {
            return Err(walk.fault("it has no keys"));
        }
        let mut keys = Self::default();
        loop {
            let key = match walk.next()? {
                Event::MappingEnd => break,
                Event::Scalar(key, ..) if key.len() > LONGEST_NAME => {
                    return Err(walk.fault(&format!("a key of {} bytes: {}", key.len(), short(&key))));
                }
                Event::Scalar(key, ..) => Some(key),
                other => {
                    walk.skip(&other)?;
                    None
                }
            };
            let line = walk.line;
            let value = walk.next()?;
            match key.and_then(|key| wanted.iter().find(|name| **name == key)) {
                None => walk.skip(&value)?,
                Some(name) => {
                    let value = walk.value(name, value)?;
                    if keys.0.insert(name, value).is_some() {
                        return Err(Fault { line, why: format!("{name} stands twice") });
                    }
                }
            }
        }
        while let Some(next) = walk.parser.next_event() {
            if let (Event::DocumentStart(..), _) = walk.event(next)? {
                return Err(walk.fault("a second document begins"));
            }
        }
        Ok(keys)
    }
}

/// The events of a text in order.
struct Walk<'a> {
    parser: Parser<'a, granit_parser::StrInput<'a>>,
    line: usize,
}

impl<'a> Walk<'a> {
    fn fault(&self, why: &str) -> Fault {
        Fault { line: self.line.max(1), why: why.to_owned() }
    }

    fn event<T>(&mut self, event: Result<(T, Span), ScanError>) -> Result<(T, Span), Fault> {
        let event = event.map_err(|e| Fault { line: e.marker().line().max(1), why: e.info() })?;
        self.line = event.1.start.line();
        Ok(event)
    }

    fn next(&mut self) -> Result<Event<'a>, Fault> {
        match self.parser.next_event() {
            Some(event) => Ok(self.event(event)?.0),
            None => Err(self.fault("it ends too early")),
        }
    }

    /// The rest of what began with this event, left out.
    fn skip(&mut self, first: &Event) -> Result<(), Fault> {
        let mut depth = deeper(first);
        while depth > 0 {
            depth += deeper(&self.next()?);
            if depth > YAML_DEPTH as i32 {
                return Err(self.fault(&format!("lists and keys are nested deeper than {YAML_DEPTH} levels")));
            }
        }
        Ok(())
    }

    /// A scalar or a list of scalars.
    fn value(&mut self, key: &str, first: Event<'a>) -> Result<Value, Fault> {
        let line = self.line;
        match first {
            Event::Scalar(text, style, ..) => Ok(Value::One(scalar(&text, style, line))),
            Event::SequenceStart(..) => {
                let mut scalars = Vec::new();
                loop {
                    match self.next()? {
                        Event::SequenceEnd => return Ok(Value::List(scalars, line)),
                        Event::Scalar(..) if scalars.len() >= YAML_LIST => {
                            return Err(self.fault(&format!("{key} has more than {YAML_LIST} values")));
                        }
                        Event::Scalar(text, style, ..) => scalars.push(scalar(&text, style, self.line)),
                        _ => return Err(self.fault(&format!("{key} is not a plain list"))),
                    }
                }
            }
            Event::Alias(_) => Err(self.fault(&format!("{key} is an alias: write its value here"))),
            _ => Err(self.fault(&format!("{key} holds further keys"))),
        }
    }
}

fn deeper(event: &Event) -> i32 {
    match event {
        Event::SequenceStart(..) | Event::MappingStart(..) => 1,
        Event::SequenceEnd | Event::MappingEnd => -1,
        _ => 0,
    }
}

fn scalar(text: &str, style: ScalarStyle, line: usize) -> Scalar {
    let is_null = style == ScalarStyle::Plain && matches!(text, "" | "~" | "null" | "Null" | "NULL");
    Scalar { text: text.to_owned(), is_null, line }
}

#[cfg(test)]
mod tests {
    use super::Keys;

    const WANTED: [&str; 3] = ["a", "b", "list"];

    #[test]
    fn scalars_and_lists_are_read_in_each_of_their_styles_and_others_left_out() {
        let text = "%YAML 1.2\n---\n# first\na: 'it''s'  # quoted\nb: -1.5e1\nother: {x: [1, {y: 2}], z: &n 3}\n? [k]\n: *n\n\
                    list:\n- 1\n- .5\n- \"-2\"\n...\n";
        let keys = Keys::read(text, &WANTED).unwrap();
        assert_eq!(keys.text("a"), Ok(Some("it's")));
        assert_eq!(keys.number("b"), Ok(Some(-15.0)));
        assert_eq!(keys.numbers("list"), Ok(Some(vec![1.0, 0.5, -2.0])));
        let keys = Keys::read("{a: ~, b: .inf, list: []}", &WANTED).unwrap();
        assert_eq!((keys.text("a"), keys.number("b")), (Ok(None), Ok(Some(f64::INFINITY))));
        assert_eq!((keys.numbers("list"), keys.text("c")), (Ok(Some(vec![])), Ok(None)));
    }

    #[test]
    fn faults_name_their_line() {
        for (text, line, word) in [
            ("", 1, "no keys"),
            ("- a", 1, "no keys"),
            ("a: 1\na: 2", 2, "a stands twice"),
            ("a: 1\nlist: [1, [2]]", 2, "list is not a plain list"),
            ("a: &x 1\nb: *x", 2, "b is an alias"),
            ("a: 1\n\nb: {c: 1}", 3, "b holds further keys"),
            ("a: 1\n  b: 2", 2, "mapping values"),
            ("a: [1, 2", 1, ""),
            ("a: 1\n---\nb: 2", 2, "second document"),
        ] {
            let fault = Keys::read(text, &WANTED).unwrap_err();
            assert!(fault.why.contains(word) && fault.line >= line && fault.line <= line + 1, "{text:?}: {fault:?}");
        }
        let keys = Keys::read("a: x\nlist:\n- 1\n- one", &WANTED).unwrap();
        assert_eq!(keys.number("a").unwrap_err().line, 1);
        assert_eq!(keys.numbers("list").unwrap_err().line, 4);
        assert!(keys.number("list").is_err() && keys.numbers("a").is_err());
    }
}
