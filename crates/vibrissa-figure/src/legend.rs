//! A legend in its own margin: one sample and one line of words each.

use super::document::{Document, number};

/// What a legend entry shows beside its words; each takes the stylesheet class of the thing itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sample {
    /// A stroke.
    Line(&'static str),
    /// A filled patch.
    Patch(&'static str),
    /// Dots with heading ticks: the dots' class, the ticks' class.
    Dots(&'static str, &'static str),
    /// A circle.
    Circle(&'static str),
    /// A marker with a heading: the circle's class, the line's class.
    Heading(&'static str, &'static str),
}

/// One line of a legend.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// The sample on the left.
    pub sample: Sample,
    /// The words; kept short, they are not wrapped.
    pub words: String,
}

/// The height of one legend line in page units.
pub(crate) const LINE: f64 = 21.0;

/// Draws a legend with its upper left corner at `(x, y)`.
pub fn legend(document: &mut Document, x: f64, y: f64, entries: &[Entry]) {
    for (index, entry) in entries.iter().enumerate() {
        let middle = y + LINE * (index as f64 + 0.5);
        document.raw(&sample(entry.sample, x, middle));
        document.text(x + 32.0, middle + 4.5, "label", &entry.words);
    }
}

fn sample(sample: Sample, x: f64, y: f64) -> String {
    let (left, mid, right, height) = (number(x + 1.0), number(x + 12.0), number(x + 23.0), number(y));
    match sample {
        Sample::Line(class) => format!("<path d=\"M{left} {height}H{right}\" class=\"{class}\"/>\n"),
        Sample::Patch(class) => {
            let top = number(y - 6.0);
            format!("<rect x=\"{left}\" y=\"{top}\" width=\"22\" height=\"12\" class=\"{class}\"/>\n")
        }
        Sample::Dots(dot, tick) => {
            let places = [(x + 4.0, y + 4.0), (x + 12.0, y - 1.0), (x + 20.0, y + 3.0)];
            let dots: String = places.iter().map(|p| format!("M{} {}h0", number(p.0), number(p.1))).collect();
            let ticks: String = places.iter().map(|p| format!("M{} {}l3 -6", number(p.0), number(p.1))).collect();
            format!("<path d=\"{dots}\" class=\"{dot}\"/>\n<path d=\"{ticks}\" class=\"{tick}\"/>\n")
        }
        Sample::Circle(class) => format!("<circle cx=\"{mid}\" cy=\"{height}\" r=\"4.5\" class=\"{class}\"/>\n"),
        Sample::Heading(mark, line) => {
            let from = number(x + 6.0);
            format!(
                "<path d=\"M{from} {height}H{right}\" class=\"{line}\"/>\n\
                 <circle cx=\"{from}\" cy=\"{height}\" r=\"5\" class=\"{mark}\"/>\n"
            )
        }
    }
}
