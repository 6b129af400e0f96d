//! The map, the strip that a reading leaves of it, and the fusion of two readings.

use super::contact_sets::{LOAD, STRIP, contacts, model};
use super::{Cell, Section, Table, ground};
use vibrissa::Result;
use vibrissa::figure::{Outline, PreimageFigure, contact_plate, preimage_plate};
use vibrissa::flow::contact_set::{ContactModel, ContactSet, MomentRegime, Parts, Reading, VirtualSensor};
use vibrissa::flow::preimage::{Construction, PreimageOptions, Raster, StateGrid, reading_preimage};
use vibrissa::plane::Pose2;
use vibrissa::sets::Interval;
use vibrissa::world::Map;

/// Nodes of a curve.
const NODES: usize = 120;
/// Half a cell of the contact strip (m).
const CELL: f64 = 1e-3;
/// Side of the cells in which places are kept (m).
const RASTER: f64 = 2e-3;

/// Moments of the two cases (N m): just below the threshold of small angles, and far above it.
const MOMENTS: [(&str, f64, MomentRegime); 2] =
    [("small", 1.1e-3, MomentRegime::SmallAngle), ("large", 8e-3, MomentRegime::LargeAngle)];

pub(super) fn section() -> Result<Section> {
    let mut section = Section::new("preimages", "The map, preimages and fusion");
    let map = ground::arena()?;
    let outlines = ground::outlines(&map);
    let model = model()?;
    // Side contact, as in the paper: the force is normal to the whisker.
    let side = PreimageOptions { contacts: Parts::Side, cell: RASTER, ..PreimageOptions::default() };
    let load = Reading::exact(VirtualSensor::Load, LOAD);
    let strip = Reading { sensor: VirtualSensor::Strip, value: Interval::new(STRIP - CELL, STRIP + CELL) };
    let solve = |readings: &[Reading], construction| {
        let options = PreimageOptions { construction, ..side };
        reading_preimage(&map, &model, Pose2::IDENTITY, readings, &options).map(|preimage| preimage.states)
    };
    let none = StateGrid::empty(Raster::over(map.bounds(), 0.01), 4);
    let wide = solve(&[load], Construction::Distance)?;
    let aligned = solve(&[load], Construction::Alignment)?;
    let fused = solve(&[load, strip], Construction::Alignment)?;
    let picture = |title: &str, states: &StateGrid| states_plate(title, &outlines, states);
    section.show(
        "strip",
        [
            "Figure “preimageSimple”: (a) a map with straight, concave, convex and symmetric boundary; (b) the strip along \
             the boundary that one load reading leaves of it.",
            "An arena with the same kinds of boundary, and what 0.1 N leaves: by directional distance, and with the whisker \
             laid along the boundary.",
            "The paper's map has no dimensions: ours is built after its description. The strip covers all states; the area \
             counts places that have at least one heading.",
        ],
        vec![
            picture("(a) The map", &none),
            picture("(b) Load 0.1 N, by directional distance", &wide),
            picture("(c) Load 0.1 N, whisker along the boundary", &aligned),
        ],
    );
    let sets =
        [ContactSet::new(&model, load.sensor, LOAD, NODES)?, ContactSet::new(&model, strip.sensor, STRIP, NODES)?];
    let (figure, shared) =
        contacts("(a) Contacts of load and contact strip", &[(&sets[0], "load 0.1 N"), (&sets[1], "strip 60 mm")]);
    section.show(
        "fusion",
        [
            "Figure “combinedSensing”: (a) contact sets of load and contact strip cross in the contact; (b) the preimage of \
             both is thinner.",
            "The same for 0.1 N and 60 mm (a cell of 59 to 61 mm for the preimage).",
            "One crossing with one and the same shape is left.",
        ],
        vec![contact_plate(&figure), picture("(b) States that explain both", &fused)],
    );
    augmented(&mut section, &map, &model, &side)?;
    let area = |states: &StateGrid| 1e4 * states.area();
    section.tell(
        "map.area",
        1e4 * map.boundaries().iter().map(|b| b.curve().signed_area().abs()).sum::<f64>(),
        1,
        "cm²",
    );
    section.tell("distance.area", area(&wide), 1, "cm²");
    section.tell("aligned.area", area(&aligned), 1, "cm²");
    section.tell("fused.area", area(&fused), 1, "cm²");
    section.say(
        "Of {preimages.map.area} cm² the load alone leaves {preimages.distance.area} cm² of places by distance and \
         {preimages.aligned.area} cm² by alignment; load and strip together leave {preimages.fused.area} cm².",
    );
    section.find(
        "Crossings of the two contact sets that are one shape",
        "fusion.crossings",
        "the contact point",
        (shared.len() as f64, 0, ""),
        "The paper holds that an intersection is connected; in general it is not, and we return every component.",
    );
    section.find(
        "Volume of the states (place and heading): both readings over load alone",
        "fusion.share",
        "reduced uncertainty",
        (fused.volume() / aligned.volume(), 3, ""),
        "The fused set is a subset.",
    );
    Ok(section)
}

/// The preimages of a small and of a large moment by both constructions: areas in the plane, volumes with the heading.
fn augmented(section: &mut Section, map: &Map, model: &ContactModel, side: &PreimageOptions) -> Result<()> {
    let mut rows: Vec<Vec<Cell>> = Vec::new();
    for (name, construction) in [("distance", Construction::Distance), ("alignment", Construction::Alignment)] {
        let mut row: Vec<Cell> = vec![format!("by {name}").into()];
        let mut sizes = Vec::new();
        for (case, moment, regime) in MOMENTS {
            let reading = Reading::exact(VirtualSensor::Moment(regime), moment);
            let options = PreimageOptions { construction, ..*side };
            let states = reading_preimage(map, model, Pose2::IDENTITY, &[reading], &options)?.states;
            let (area, volume) = (1e4 * states.area(), 1e4 * states.volume());
            row.push(section.named(&format!("{case}.{name}.area"), area, 0, "cm²").into());
            row.push(section.named(&format!("{case}.{name}.volume"), volume, 0, "cm² rad").into());
            sizes.push([area, volume]);
        }
        for (which, what) in ["area", "volume"].into_iter().enumerate() {
            section.tell(&format!("{name}.{what}_share"), sizes[1][which] / sizes[0][which], 2, "");
        }
        rows.push(row);
    }
    let head =
        ["construction", "1.1 mN m, small angles: area", "its volume", "8 mN m, large angles: area", "its volume"];
    section.tables.push(Table {
        key: "augmented",
        title: "Preimages of a small and of a large moment, both constructions (area in cm², volume in cm² rad)".into(),
        head: head.map(str::to_owned).to_vec(),
        rows,
    });
    section.say(
        "The paper holds that at large angles the preimage's area is smaller and the augmented set `Q_aug` larger. From 1.1 to 8 mN m \
         the area changes by the factor {preimages.distance.area_share} and the volume by {preimages.distance.volume_share} by \
         directional distance, by {preimages.alignment.area_share} and {preimages.alignment.volume_share} by alignment.",
    );
    Ok(())
}

fn states_plate(title: &str, map: &[Outline], states: &StateGrid) -> String {
    preimage_plate(&PreimageFigure { title: title.to_owned(), map, states, heading: None })
}
