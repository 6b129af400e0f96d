//! The SVG page: header, stylesheet, text and the pieces that panels put on it.

use super::style;
use std::fmt::Write;
use vibrissa_core::error::is_steering;

/// Text made safe for XML content and attributes; characters that XML forbids, and those that
/// [steer a viewer](vibrissa_core::error::is_steering) instead of being seen, become U+FFFD.
#[must_use]
pub fn escape(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&apos;"),
            '\t' | '\n' | '\r' => safe.push(' '),
            '\u{fffe}' | '\u{ffff}' => safe.push('\u{fffd}'),
            steering if is_steering(steering) => safe.push('\u{fffd}'),
            other => safe.push(other),
        }
    }
    safe
}

/// Longest text on a page (characters): what is longer leaves it on the right.
const LONGEST: usize = 400;

/// As [`escape`], cut where it would be longer than any line.
pub(crate) fn escaped_line(text: &str) -> String {
    match text.char_indices().nth(LONGEST) {
        Some((at, _)) => escape(&text[..at]) + "…",
        None => escape(text),
    }
}

/// A page coordinate with at most two decimals and no negative zero, so that equal figures are equal bytes.
pub(crate) fn number(value: f64) -> String {
    let text = format!("{:.2}", value.clamp(-1e6, 1e6));
    let short = text.trim_end_matches('0').trim_end_matches('.');
    if short == "-0" { "0".into() } else { short.into() }
}

/// An SVG page under construction; lengths are page units, of which a screen shows one per pixel.
#[derive(Clone, Debug)]
pub struct Document {
    width: f64,
    height: f64,
    title: String,
    description: String,
    body: String,
    clips: usize,
}

impl Document {
    /// An empty white page with a title and a description for readers who cannot see it.
    #[must_use]
    pub fn new(width: f64, height: f64, title: &str, description: &str) -> Self {
        Self {
            width,
            height,
            title: escaped_line(title),
            description: escape(description),
            body: String::new(),
            clips: 0,
        }
    }

    /// Puts one line of text with its anchor at `(x, y)`.
    pub fn text(&mut self, x: f64, y: f64, class: &str, text: &str) {
        let _ = writeln!(
            self.body,
            r#"<text x="{}" y="{}" class="{class}">{}</text>"#,
            number(x),
            number(y),
            escaped_line(text)
        );
    }

    /// Puts a straight line.
    pub fn line(&mut self, from: (f64, f64), to: (f64, f64), class: &str) {
        let [x1, y1, x2, y2] = [from.0, from.1, to.0, to.1].map(number);
        let _ = writeln!(self.body, r#"<line x1="{x1}" y1="{y1}" x2="{x2}" y2="{y2}" class="{class}"/>"#);
    }

    /// Puts a rectangle by its upper left corner and size.
    pub fn rectangle(&mut self, corner: (f64, f64), size: (f64, f64), class: &str) {
        let [x, y, width, height] = [corner.0, corner.1, size.0, size.1].map(number);
        let _ = writeln!(self.body, r#"<rect x="{x}" y="{y}" width="{width}" height="{height}" class="{class}"/>"#);
    }

    /// Puts ready-made elements.
    pub(crate) fn raw(&mut self, elements: &str) {
        self.body.push_str(elements);
    }

    /// Puts ready-made elements, cut off at a rectangle.
    pub(crate) fn clipped(&mut self, corner: (f64, f64), size: (f64, f64), elements: &str) {
        let id = self.clips;
        self.clips += 1;
        let [x, y, width, height] = [corner.0, corner.1, size.0, size.1].map(number);
        let _ = writeln!(
            self.body,
            r#"<clipPath id="panel{id}"><rect x="{x}" y="{y}" width="{width}" height="{height}"/></clipPath>"#
        );
        let _ = write!(self.body, "<g clip-path=\"url(#panel{id})\">\n{elements}</g>\n");
    }

    /// The finished page.
    #[must_use]
    pub fn finish(self) -> String {
        let (width, height) = (number(self.width), number(self.height));
        let (title, description, style, body) = (self.title, self.description, style::SHEET, self.body);
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" role=\"img\">\n<title>{title}</title>\n<desc>{description}</desc>\n\
             <style>\n{style}</style>\n<rect width=\"{width}\" height=\"{height}\" class=\"page\"/>\n{body}</svg>\n"
        )
    }
}
