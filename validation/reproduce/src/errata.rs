//! Where the paper is wrong or loose, and what is done here instead.

use super::{Cell, Section, Table};
use vibrissa::Result;
use vibrissa::beam::normal::largest_moment;

/// Place, what stands there, what we do; the numbers are those of `docs/departures.md`.
const LIST: [(u8, &str, &str, &str); 12] = [
    (
        1,
        "Large-angle moment equation",
        "The root holds sin φ − sin φₐ, negative over the whole range.",
        "sin φₐ − sin φ.",
    ),
    (
        2,
        "Shape equations and load sensor",
        "The shapes belong to a force of fixed direction, the experiments to one normal to the whisker.",
        "The load model is always named; normal is the default.",
    ),
    (
        3,
        "Proposition on intersections",
        "The intersection of two contact sets is said to be connected; it is not.",
        "Every component is kept.",
    ),
    (4, "Abstract and table", "Errors under 7 mm; the table's largest is 7.30 mm.", "We compare with the table."),
    (
        5,
        "Table of contact points",
        "The earlier method's column is the small-angle formula.",
        "Computed to the digit above.",
    ),
    (
        6,
        "Figure of filtering",
        "17 and 25 mN m belong to the force of fixed direction (0.51 and 1.08 N at the tip); a force normal to the whisker gives \
         them nearer than 50 and 34 mm only. The table has 0.19 to 0.63 mN m.",
        "The load is named; the figure's values are no targets.",
    ),
    (
        7,
        "Localization",
        "Orientation is announced, no number is given.",
        "Headings are estimated and compared, see above.",
    ),
    (
        8,
        "Alignment equation",
        "γ = π − (φₐ + φ_E) holds for slopes counted clockwise.",
        "Derived anew, counter-clockwise.",
    ),
    (9, "Localization", "State sets are intersected in x and y alone.", "In x, y and heading."),
    (10, "Sensor fabrication", "E = 52 GPa, 0.58 mm wire, I = 5.555e-15 m⁴, L = 75 mm.", "The defaults."),
    (
        11,
        "Force at the tip",
        "Normal to the whisker, as elastica2D has it.",
        "Normal to the boundary; the paper's is an option. The localization table has both.",
    ),
    (
        12,
        "Deterministic method",
        "Exact intersection of sampled curves, empty with readings off by percents.",
        "A tolerance from the declared errors; a share of observations may be missed.",
    ),
];

pub(super) fn section() -> Result<Section> {
    let mut section = Section::new("errata", "Where the paper is wrong or loose");
    let row = |(nr, place, stands, ours): (u8, &str, &str, &str)| -> Vec<Cell> {
        vec![section.named(&format!("row_{nr}"), f64::from(nr), 0, "").into(), place.into(), stands.into(), ours.into()]
    };
    let table = Table {
        key: "errata",
        title: "Departures, numbered as in docs/departures.md".into(),
        head: ["nr", "place", "what stands there", "what we do"].map(str::to_owned).to_vec(),
        rows: LIST.into_iter().map(row).collect(),
    };
    section.tables.push(table);
    section.tell("largest_moment", largest_moment(), 4, "");
    section.say(
        "Under a load normal to the whisker M(0) sₐ / E I is at most {errata.largest_moment}; docs/theory-beam.md derives it, and \
         tests show rows 1 to 10 by numbers.",
    );
    Ok(section)
}
