//! Draws the figures of `docs/contact-sets.md`, panel by panel what the paper's figures 3 to 6 show.
//!
//! Usage: `cargo run --release --example contact_set_figures [-- FOLDER]`

use std::path::Path;
use vibrissa::Result;
use vibrissa::beam::{Load, Whisker};
use vibrissa::figure::{
    ContactFigure, Document, Frame, Outline, OutlineRole, PreimageFigure, contact_legend, contact_panel, legend,
    preimage_legend, preimage_panel,
};
use vibrissa::flow::contact_set::{
    ContactModel, ContactSet, Limits, MomentRegime, Parts, PlacedSet, Reading, VirtualSensor, intersect,
};
use vibrissa::flow::preimage::{Construction, PreimageOptions, Raster, StateGrid, reading_preimage};
use vibrissa::plane::Pose2;
use vibrissa::tasks::demo;
use vibrissa::world::{Map, Role};

const LEFT: Frame = Frame { x: 64.0, y: 56.0, width: 380.0, height: 330.0 };
const RIGHT: Frame = Frame { x: 524.0, y: 56.0, width: 380.0, height: 330.0 };
const SHAPES: usize = 13;

/// The paper's whisker, loaded by no more than half a newton.
fn model() -> Result<ContactModel> {
    ContactModel::new(&Whisker::default(), Load::Normal)?.with_limits(Limits { force: 0.5, ..Limits::default() })
}

fn page(title: &str) -> Document {
    Document::new(930.0, 540.0, title, title)
}

/// The contacts of readings, with shapes along the first.
fn contacts(model: &ContactModel, readings: &[(VirtualSensor, f64, &str)]) -> Result<ContactFigure> {
    let mut figure = ContactFigure { length: model.length(), ..ContactFigure::default() };
    let mut sets = Vec::new();
    for &(sensor, value, words) in readings {
        let set = ContactSet::new(model, sensor, value, 200)?;
        for curve in &set.curves {
            let step = curve.contacts().len().div_ceil(SHAPES);
            let shapes = curve.contacts().iter().step_by(step).chain(curve.contacts().last());
            figure.shapes.extend(shapes.map(|c| set.model().shape(c, 81)));
            figure.curves.push((words.into(), curve.points()));
        }
        sets.push(set);
    }
    if let [a, b] = &sets[..] {
        let meetings = intersect(PlacedSet::at_home(a), PlacedSet::at_home(b), 1e-9);
        figure.points = meetings.iter().filter(|m| m.is_one_shape()).map(|m| m.position).collect();
    }
    Ok(figure)
}

fn put_contacts(document: &mut Document, frame: Frame, heading: &str, figure: &ContactFigure) {
    document.text(frame.x, frame.y - 14.0, "heading", heading);
    contact_panel(document, frame, figure);
    legend(document, frame.x, frame.y + frame.height + 44.0, &contact_legend(figure));
}

fn put_states(document: &mut Document, frame: Frame, heading: &str, figure: &PreimageFigure<'_>) {
    document.text(frame.x, frame.y - 14.0, "heading", heading);
    preimage_panel(document, frame, figure);
    legend(document, frame.x, frame.y + frame.height + 44.0, &preimage_legend(figure));
}

fn outlines(map: &Map) -> Vec<Outline> {
    let role = |r: Role| match r {
        Role::Arena => OutlineRole::Arena,
        Role::Obstacle => OutlineRole::Obstacle,
        Role::Wall => OutlineRole::Wall,
    };
    let one = |b: &vibrissa::world::Boundary| {
        let mut points = b.curve().flatten(2e-5);
        points.pop();
        Outline::exact(points, role(b.role()), true)
    };
    map.boundaries().iter().map(one).collect()
}

fn main() -> std::result::Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "docs/figures".into());
    std::fs::create_dir_all(&folder)?;
    let write = |name: &str, document: Document| std::fs::write(Path::new(&folder).join(name), document.finish());
    let model = model()?;
    let small = VirtualSensor::Moment(MomentRegime::Auto);
    let large = VirtualSensor::Moment(MomentRegime::LargeAngle);
    let load = (VirtualSensor::Load, 0.1, "load 0.1 N");
    let strip = (VirtualSensor::Strip, 0.06, "strip 60 mm, up to 0.5 N");

    let mut document = page("Contacts that explain a load and a contact strip");
    put_contacts(&mut document, LEFT, "(a) Load sensor", &contacts(&model, &[load])?);
    put_contacts(&mut document, RIGHT, "(b) Contact strip sensor", &contacts(&model, &[strip])?);
    write("contact-load-strip.svg", document)?;

    let mut document = page("Contacts that explain an end slope and a moment");
    let slope = (VirtualSensor::Slope, 0.7, "end slope 40 degrees, up to 0.5 N");
    put_contacts(&mut document, LEFT, "(a) End-slope sensor", &contacts(&model, &[slope])?);
    let gentle = (small, 1.1e-3, "moment 1.1 mN m, small angles");
    put_contacts(&mut document, RIGHT, "(b) Bending moment sensor, small angles", &contacts(&model, &[gentle])?);
    write("contact-slope-moment.svg", document)?;

    let mut document = page("Contacts that explain a moment at large angles");
    let whole = ContactModel::new(&Whisker::default(), Load::Normal)?;
    let (apart, loop_) = ((large, 6e-3, "moment 6 mN m"), (large, 17e-3, "moment 17 mN m"));
    put_contacts(&mut document, LEFT, "(a) 6 mN m: two branches, cut at the tip", &contacts(&whole, &[apart])?);
    put_contacts(&mut document, RIGHT, "(b) 17 mN m: one loop, 50 mm at most", &contacts(&whole, &[loop_])?);
    write("contact-moment-large.svg", document)?;

    let arena = demo::arena()?;
    let map = outlines(&arena);
    // The paper's: the force is normal to the whisker.
    let side = PreimageOptions { contacts: Parts::Side, ..PreimageOptions::default() };
    let options = PreimageOptions { construction: Construction::Distance, ..side };
    let solve = |readings: &[Reading], options: &PreimageOptions| {
        reading_preimage(&arena, &model, Pose2::IDENTITY, readings, options)
    };
    let exact = |reading: (VirtualSensor, f64, &str)| Reading::exact(reading.0, reading.1);
    let wide = solve(&[exact(load)], &options)?;
    let aligned = solve(&[exact(load)], &side)?;
    let none = StateGrid::empty(Raster::over(arena.bounds(), 0.01), 4);
    let states = |states| PreimageFigure { title: String::new(), map: &map, states, heading: None };

    let mut document = page("A map, and what a load of 0.1 N leaves of it");
    put_states(&mut document, LEFT, "(a) The map", &states(&none));
    put_states(&mut document, RIGHT, "(b) Load 0.1 N, by directional distance", &states(&wide.states));
    write("preimage-load.svg", document)?;

    let mut document = page("The same by alignment, and a slice of it");
    put_states(&mut document, LEFT, "(a) Load 0.1 N, side along the boundary", &states(&aligned.states));
    let slice = PreimageFigure { heading: Some(0.6), ..states(&aligned.states) };
    put_states(&mut document, RIGHT, "(b) One heading of it", &slice);
    write("preimage-aligned.svg", document)?;

    let fused = solve(&[exact(load), exact(strip)], &side)?;
    let mut document = page("Load and contact strip combined");
    put_contacts(&mut document, LEFT, "(a) Their contacts", &contacts(&model, &[load, strip])?);
    put_states(&mut document, RIGHT, "(b) The states that explain both", &states(&fused.states));
    write("preimage-fusion.svg", document)?;
    Ok(())
}
