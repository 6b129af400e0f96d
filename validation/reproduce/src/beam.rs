//! Large-angle deflection of the whisker.

use super::Section;
use super::ground::layer;
use vibrissa::Result;
use vibrissa::beam::{Bend, Load, Whisker, force_mode};
use vibrissa::config::defaults;
use vibrissa::figure::{Geometry, MapPlate, map_plate};
use vibrissa::plane::Vec2;

/// Forces at the tip whose shapes are drawn (N).
const FORCES: [f64; 6] = [0.01, 0.025, 0.05, 0.1, 0.2, 0.4];
/// The force of the numbers (N).
const FORCE: f64 = 0.1;
/// What the paper prints: Young's modulus (GPa), second moment of area (1e-15 m⁴), length (mm).
const PRINTED: [f64; 3] = [52.0, 5.555, 75.0];

pub(super) fn section() -> Result<Section> {
    let mut section = Section::new("beam", "The bent whisker");
    let whisker = Whisker::default();
    let bent = |force: f64, load: Load| -> Result<Option<Bend>> {
        Ok(force_mode(&whisker, force, whisker.length, load)?.into_iter().next())
    };
    let shape = |bend: &Bend| bend.shape(whisker.length, 61);
    let (normal, vertical) = (bent(FORCE, Load::Normal)?, bent(FORCE, Load::Vertical)?);
    let all = |load| -> Result<Vec<Vec<Vec2>>> {
        let bends = FORCES.iter().map(|force| bent(*force, load)).collect::<Result<Vec<_>>>()?;
        Ok(bends.iter().flatten().map(shape).collect())
    };
    let rest = layer(Geometry::Lines(vec![vec![Vec2::ZERO, Vec2::new(whisker.length, 0.0)]]), "undeflected", "at rest");
    let base = layer(Geometry::Circles(vec![Vec2::ZERO]), "base", "clamped base");
    let plate = |title: &str, layers: &[vibrissa::figure::Layer]| {
        map_plate(&MapPlate { title, map: &[], layers, window: None, frame: "whisker frame" })
    };
    let shapes = plate(
        "Loads of 0.01 to 0.4 N at the tip, normal to the whisker",
        &[
            rest.clone(),
            layer(Geometry::Lines(all(Load::Normal)?), "contact-a", "shapes, each the twofold of the one before"),
            base.clone(),
        ],
    );
    let of = |bend: &Option<Bend>| bend.iter().map(shape).collect::<Vec<_>>();
    let loads = plate(
        "0.1 N at the tip: normal to the whisker, or vertical",
        &[
            rest,
            layer(Geometry::Lines(of(&normal)), "contact-a", "normal to the whisker (load sensor, experiments)"),
            layer(Geometry::Lines(of(&vertical)), "contact-b", "vertical throughout (the shape equations)"),
            base,
        ],
    );
    section.show(
        "deflection",
        [
            "Figure “genericRepresentation” (b): a cantilever under a load at its tip, with the tip's displacements.",
            "Shapes of the paper's wire in closed form (elliptic functions).",
            "Our y points up and angles count counter-clockwise; the paper's y points down. The paper's figure has no scale.",
        ],
        vec![shapes, loads],
    );
    numbers(&mut section, &whisker, [normal, vertical]);
    Ok(section)
}

fn numbers(section: &mut Section, whisker: &Whisker, [normal, vertical]: [Option<Bend>; 2]) {
    let moved = |bend: &Option<Bend>| {
        bend.as_ref().map_or(Vec2::new(f64::NAN, f64::NAN), |b| b.tip_displacement(whisker.length))
    };
    let (n, v) = (moved(&normal), moved(&vertical));
    section.tell("delta_x", -1e3 * n.x, 2, "mm");
    section.tell("delta_y", 1e3 * n.y, 2, "mm");
    section.say(
        "At 0.1 N across its tip the paper's wire yields by δx = {beam.delta_x} mm and δy = {beam.delta_y} mm: far beyond \
         small angles, which end at a tenth of the length.",
    );
    section.find(
        "Contact at 0.1 N: load normal to the whisker against a vertical load",
        "load_gap",
        "one set of equations for both",
        (1e3 * n.distance(v), 2, "mm"),
        "The shape equations hold for a load of fixed direction, the sensor model and the experiments have one normal to \
         the whisker. We name the load model.",
    );
    let lever = vertical.as_ref().map_or(f64::NAN, |b| 1e3 * b.contact.cross(b.force_vector()));
    section.tell("lever", lever, 4, "mN m");
    section.find(
        "Moment M(0) at 0.1 N, vertical, by the large-angle equation",
        "moment",
        "the root of a negative number, as printed",
        (vertical.as_ref().map_or(f64::NAN, |b| 1e3 * b.moment), 4, "mN m"),
        "The printed root holds sin φ − sin φₐ. The other way round, as here, it gives force times lever: {beam.lever} mN m.",
    );
    let second_moment = core::f64::consts::PI * defaults::DIAMETER.powi(4) / 64.0;
    section.compare(
        "Second moment of area of a 0.58 mm wire",
        "second_moment",
        (PRINTED[1], 1e15 * second_moment),
        (3, "1e-15 m⁴"),
        "π d⁴ / 64.",
    );
    section.compare(
        "Flexural rigidity E I",
        "rigidity",
        (1e4 * PRINTED[0] * 1e9 * PRINTED[1] * 1e-15, 1e4 * whisker.flexural_rigidity),
        (4, "1e-4 N m²"),
        "The product of the printed constants is our default.",
    );
    section.compare("Length of the whisker", "length", (PRINTED[2], 1e3 * whisker.length), (0, "mm"), "The default.");
}
