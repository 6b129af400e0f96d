//! `report.html`: one page that needs nothing else; well-formed XML that is HTML, too.

use std::collections::BTreeMap;
use std::fmt::Write;
use vibrissa::figure::{escape, stylesheet};
use vibrissa_reproduce::{Cell, Comparison, Figure, Number, Panel, Reproduction, Section, Table};

/// The page's own styles.
const SHEET: &str = include_str!("page.css");
/// What a reader must know first.
pub(super) const ABOUT: [&str; 3] = [
    "This page makes the figures and tables of “Mobile Robot Localization Using a Novel Whisker-Like Sensor” (Routray, \
     Sakcak, LaValle, Manivannan) anew and sets ours beside them.",
    "Everything of ours on this page is simulated, by this project's own simulator: a quasi-static whisker of the paper's \
     wire in a plane, without friction unless said otherwise, with readings off by up to 5 % and 20 µN m. Numbers of the paper are those \
     it prints, measured on its sensor. The paper's recordings, maps and objects are not public; maps and sweeps here are \
     built after its description. So a smaller error here is no proof of a better sensor.",
    "Photographs and drawings of hardware and frames (figures “sensor-typical”, “fig_OneB”, “setupSensor” and “expSetup” (a)) \
     have no content to make anew and are left out.",
];

/// The page as text.
pub(super) fn text(answer: &Reproduction) -> String {
    let numbers: BTreeMap<&str, &Number> = answer.numbers().into_iter().map(|n| (n.key.as_str(), n)).collect();
    let page = Page { numbers };
    let about: String = ABOUT.iter().map(|words| format!("<p>{}</p>\n", escape(words))).collect();
    let contents: String = answer
        .sections
        .iter()
        .map(|section| format!("<li><a href=\"#{}\">{}</a></li>\n", section.key, escape(section.title)))
        .collect();
    let sections: String = answer.sections.iter().map(|section| page.section(section)).collect();
    format!(
        "<!DOCTYPE html>\n<html xmlns=\"http://www.w3.org/1999/xhtml\" lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <meta name=\"color-scheme\" content=\"light dark\"/>\n<link rel=\"icon\" href=\"data:,\"/>\n\
         <title>The paper and vibrissa, side by side</title>\n<style>\n{figures}{SHEET}</style>\n</head>\n<body>\n<main>\n\
         <h1>The paper and vibrissa, side by side</h1>\n<div class=\"about\">\n{about}</div>\n\
         <nav aria-label=\"Contents\">\n<ul>\n{contents}</ul>\n</nav>\n{sections}</main>\n</body>\n</html>\n",
        figures = scoped(stylesheet()),
    )
}

/// The figures' rules, each for pictures only.
fn scoped(sheet: &str) -> String {
    let rule = |rule: &str| {
        let (selectors, body) = rule.split_once('{')?;
        let selectors: Vec<String> = selectors.split(',').map(|s| format!("svg {}", s.trim())).collect();
        Some(format!("{} {{{body}}}\n", selectors.join(", ")))
    };
    sheet.split('}').filter_map(rule).collect()
}

/// What the pieces of the page share.
struct Page<'a> {
    numbers: BTreeMap<&'a str, &'a Number>,
}

impl Page<'_> {
    fn section(&self, section: &Section) -> String {
        let mut text = format!("<section id=\"{}\">\n<h2>{}</h2>\n", section.key, escape(section.title));
        for paragraph in &section.text {
            let _ = writeln!(text, "<p>{}</p>", self.prose(paragraph));
        }
        section.tables.iter().for_each(|table| text.push_str(&self.table(table)));
        text.push_str(&self.comparisons(&section.comparisons));
        section.figures.iter().for_each(|figure| text.push_str(&self.figure(section.key, figure)));
        text.push_str("</section>\n");
        text
    }

    /// Words in which `{key}` stands for a number.
    fn prose(&self, words: &str) -> String {
        let mut text = String::new();
        let mut rest = words;
        while let Some((before, after)) = rest.split_once('{') {
            text.push_str(&escape(before));
            let (key, left) = after.split_once('}').unwrap_or((after, ""));
            match self.numbers.get(key) {
                Some(number) => text.push_str(&spelled(number)),
                None => text.push_str(&escape(key)),
            }
            rest = left;
        }
        coded(&kept_together(&(text + &escape(rest))))
    }

    fn table(&self, table: &Table) -> String {
        let head: String = table.head.iter().map(|words| format!("<th scope=\"col\">{}</th>", escape(words))).collect();
        let mut text = format!(
            "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"{0}\">\n<table id=\"table-{1}\">\n<caption>{0}</caption>\n<thead><tr>{head}</tr></thead>\n<tbody>\n",
            escape(&table.title),
            table.key
        );
        for row in &table.rows {
            let cells: String = row.iter().map(|cell| field(cell, false)).collect();
            let _ = writeln!(text, "<tr>{cells}</tr>");
        }
        text + "</tbody>\n</table>\n</div>\n"
    }

    fn comparisons(&self, comparisons: &[Comparison]) -> String {
        if comparisons.is_empty() {
            return String::new();
        }
        let mut text = String::from("<div class=\"compared\">\n");
        for one in comparisons {
            let _ = writeln!(
                text,
                "<div class=\"pair\"><h3>{}</h3><dl>{}<div><dt>ours</dt>{}</div>{}</dl><p>{}</p></div>",
                escape(&one.what),
                match &one.paper {
                    // The paper tells nothing of it.
                    Cell::Words(words) if words == "no number" => String::new(),
                    cell => format!("<div><dt>paper</dt>{}</div>", definition(cell)),
                },
                definition(&one.ours),
                match &one.difference {
                    Cell::Words(words) if words.is_empty() => String::new(),
                    Cell::Number(number) if !number.value.is_finite() => String::new(),
                    cell => format!("<div><dt>difference</dt>{}</div>", definition(cell)),
                },
                self.prose(&one.reason)
            );
        }
        text + "</div>\n"
    }

    fn figure(&self, section: &str, figure: &Figure) -> String {
        let panels: String =
            figure.panels.iter().map(|panel| format!("<div class=\"plate\">{}</div>\n", inline(panel))).collect();
        let difference = if figure.difference.is_empty() {
            String::new()
        } else {
            format!("<p><b>Difference.</b> {}</p>\n", self.prose(&figure.difference))
        };
        format!(
            "<figure id=\"figure-{section}-{}\">\n<div class=\"plates\">\n{panels}</div>\n<figcaption>\n<p><b>Paper.</b> {}</p>\n<p><b>Ours.</b> {}</p>\n{difference}</figcaption>\n</figure>\n",
            figure.key,
            self.prose(&figure.paper),
            self.prose(&figure.ours)
        )
    }
}

/// Code between backticks as the page's code.
fn coded(html: &str) -> String {
    let parts: Vec<&str> = html.split('`').collect();
    // An odd backtick is none.
    let last = if parts.len().is_multiple_of(2) { parts.len() - 1 } else { parts.len() };
    let part = |(index, part): (usize, &&str)| match index {
        index if index >= last => format!("`{part}"),
        index if index % 2 == 1 => format!("<code>{part}</code>"),
        _ => (*part).to_owned(),
    };
    parts.iter().enumerate().map(part).collect()
}

/// Numbers and their units on one line.
fn kept_together(html: &str) -> String {
    html.replace(" mm", "\u{a0}mm")
        .replace(" mN m", "\u{a0}mN\u{a0}m")
        .replace(" N m", "\u{a0}N\u{a0}m")
        .replace(" %", "\u{a0}%")
}

/// A number that says where it is found.
fn spelled(number: &Number) -> String {
    format!("<data data-key=\"{}\" value=\"{}\">{}</data>", escape(&number.key), number.value, escape(&number.shown()))
}

fn field(cell: &Cell, unit: bool) -> String {
    match cell {
        Cell::Words(words) => format!("<td>{}</td>", coded(&escape(words))),
        Cell::Number(number) if unit => {
            format!("<td class=\"number\">{} {}</td>", spelled(number), escape(number.unit))
        }
        Cell::Number(number) => format!("<td class=\"number\">{}</td>", spelled(number)),
    }
}

fn definition(cell: &Cell) -> String {
    match cell {
        Cell::Words(words) => format!("<dd>{}</dd>", escape(words)),
        // No number has no unit.
        Cell::Number(number) if !number.value.is_finite() => format!("<dd class=\"number\">{}</dd>", spelled(number)),
        Cell::Number(number) => format!("<dd class=\"number\">{} {}</dd>", spelled(number), escape(number.unit)),
    }
}

/// A picture within the page: names of its own, styles from the page.
fn inline(panel: &Panel) -> String {
    let without_style =
        match panel.svg.split_once("<style>").and_then(|(a, b)| Some((a, b.split_once("</style>\n")?.1))) {
            Some((before, after)) => format!("{before}{after}"),
            None => panel.svg.clone(),
        };
    let own = |name: &str| format!("{}-{name}", panel.key);
    without_style
        .replace("id=\"panel", &format!("id=\"{}", own("panel")))
        .replace("url(#panel", &format!("url(#{}", own("panel")))
}
