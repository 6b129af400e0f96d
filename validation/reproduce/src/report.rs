//! The shape of the answer: sections of figures, tables and compared numbers.

use vibrissa::figure::ChartSeries;

/// The whole page.
#[derive(Clone, Debug, PartialEq)]
pub struct Reproduction {
    /// The sections, in order.
    pub sections: Vec<Section>,
}

/// One subject of the paper.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Section {
    /// Its key, which all of its numbers' keys start with.
    pub key: &'static str,
    /// Its headline.
    pub title: &'static str,
    /// Paragraphs; `{key}` stands for the number of that key.
    pub text: Vec<String>,
    /// Figures.
    pub figures: Vec<Figure>,
    /// Tables.
    pub tables: Vec<Table>,
    /// What the paper says beside what we find.
    pub comparisons: Vec<Comparison>,
    /// Numbers that the words name and no table or comparison holds.
    pub numbers: Vec<Number>,
}

/// A number with a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Number {
    /// The name: the section's key, a dot, and what it is.
    pub key: String,
    /// The value, in `unit`; not finite where there is none.
    pub value: f64,
    /// Decimals that are shown.
    pub digits: usize,
    /// The unit; empty for counts and ratios.
    pub unit: &'static str,
}

/// One field of a table.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Words; empty where there is nothing to say.
    Words(String),
    /// A number.
    Number(Number),
}

/// A table.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Its key.
    pub key: &'static str,
    /// What it shows.
    pub title: String,
    /// The heads of its columns.
    pub head: Vec<String>,
    /// Its rows.
    pub rows: Vec<Vec<Cell>>,
}

/// A statement of the paper beside ours.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// What is compared.
    pub what: String,
    /// What the paper says.
    pub paper: Cell,
    /// What we find.
    pub ours: Cell,
    /// The difference.
    pub difference: Cell,
    /// Why they differ, or what makes them agree; `{key}` stands for a number.
    pub reason: String,
}

/// A figure of one or more panels.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Its key.
    pub key: &'static str,
    /// The paper's figure: its label and what it shows.
    pub paper: String,
    /// What ours shows.
    pub ours: String,
    /// How they differ and why.
    pub difference: String,
    /// Pictures.
    pub panels: Vec<Panel>,
}

/// One picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// Its key.
    pub key: String,
    /// The picture as SVG text.
    pub svg: String,
}

impl Number {
    /// The number as it is shown; an em dash where there is none.
    #[must_use]
    pub fn shown(&self) -> String {
        if !self.value.is_finite() {
            return "—".into();
        }
        let text = format!("{:.*}", self.digits, self.value);
        match text.strip_prefix('-') {
            Some(size) if size.chars().all(|c| matches!(c, '0' | '.')) => size.into(),
            Some(size) => format!("−{size}"),
            None => text,
        }
    }
}

impl Cell {
    /// The number, if it is one.
    #[must_use]
    pub fn number(&self) -> Option<&Number> {
        match self {
            Self::Number(number) => Some(number),
            Self::Words(_) => None,
        }
    }
}

impl From<&str> for Cell {
    fn from(words: &str) -> Self {
        Self::Words(words.to_owned())
    }
}

impl From<String> for Cell {
    fn from(words: String) -> Self {
        Self::Words(words)
    }
}

impl From<Number> for Cell {
    fn from(number: Number) -> Self {
        Self::Number(number)
    }
}

impl Reproduction {
    /// Every number, in the order of the page; a key may come more than once, with the same value.
    #[must_use]
    pub fn numbers(&self) -> Vec<&Number> {
        self.sections.iter().flat_map(Section::all_numbers).collect()
    }
}

impl Section {
    pub(super) fn new(key: &'static str, title: &'static str) -> Self {
        Self { key, title, ..Self::default() }
    }

    /// The number of this key (without the section's), if it is there.
    #[must_use]
    pub fn number(&self, name: &str) -> Option<f64> {
        let key = format!("{}.{name}", self.key);
        self.all_numbers().iter().find(|number| number.key == key).map(|number| number.value)
    }

    /// Every number of the section.
    #[must_use]
    pub fn all_numbers(&self) -> Vec<&Number> {
        let cells = self.tables.iter().flat_map(|table| table.rows.iter().flatten());
        let compared = self.comparisons.iter().flat_map(|c| [&c.paper, &c.ours, &c.difference]);
        self.numbers.iter().chain(cells.chain(compared).filter_map(Cell::number)).collect()
    }

    /// A number of this section.
    pub(super) fn named(&self, name: &str, value: f64, digits: usize, unit: &'static str) -> Number {
        Number { key: format!("{}.{name}", self.key), value, digits, unit }
    }

    /// Adds a number that words name.
    pub(super) fn tell(&mut self, name: &str, value: f64, digits: usize, unit: &'static str) {
        let number = self.named(name, value, digits, unit);
        self.numbers.push(number);
    }

    /// Adds a paragraph.
    pub(super) fn say(&mut self, words: &str) {
        self.text.push(words.to_owned());
    }

    /// Adds a figure.
    pub(super) fn show(&mut self, key: &'static str, words: [&str; 3], pictures: Vec<String>) {
        let panel = |(index, svg)| Panel { key: format!("{}-{key}-{}", self.key, index + 1), svg };
        let panels = pictures.into_iter().enumerate().map(panel).collect();
        let [paper, ours, difference] = words.map(str::to_owned);
        self.figures.push(Figure { key, paper, ours, difference, panels });
    }

    /// Sets a number of the paper beside one of ours.
    pub(super) fn compare(
        &mut self,
        what: &str,
        name: &str,
        (paper, ours): (f64, f64),
        form: (usize, &'static str),
        reason: &str,
    ) {
        let (digits, unit) = form;
        let number = |suffix: &str, value: f64| self.named(&format!("{name}.{suffix}"), value, digits, unit).into();
        let comparison = Comparison {
            what: what.to_owned(),
            paper: number("paper", paper),
            ours: number("ours", ours),
            difference: number("difference", ours - paper),
            reason: reason.to_owned(),
        };
        self.comparisons.push(comparison);
    }

    /// Sets words of the paper beside a number of ours.
    pub(super) fn find(&mut self, what: &str, name: &str, paper: &str, ours: (f64, usize, &'static str), reason: &str) {
        let (value, digits, unit) = ours;
        let comparison = Comparison {
            what: what.to_owned(),
            paper: paper.into(),
            ours: self.named(name, value, digits, unit).into(),
            difference: "".into(),
            reason: reason.to_owned(),
        };
        self.comparisons.push(comparison);
    }
}

/// A joined line of a chart.
pub(super) fn line(label: &str, class: &'static str, points: Vec<(f64, f64)>) -> ChartSeries {
    ChartSeries { label: label.to_owned(), class, points, joined: true }
}

/// A cloud of dots of a chart.
pub(super) fn dots(label: &str, class: &'static str, points: Vec<(f64, f64)>) -> ChartSeries {
    ChartSeries { label: label.to_owned(), class, points, joined: false }
}
