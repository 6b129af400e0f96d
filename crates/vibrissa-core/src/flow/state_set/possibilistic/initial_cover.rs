//! The initial cover: cells around every state that one reading allows, anywhere on the map (set inversion,
//! \[jaulin2001applied, ch. 3\]).

use super::contractor::{BoundaryLevel, ContactEntry, contacts, mirrored};
use super::errors::PoseSlack;
use super::parallelotope::Parallelotope;
use super::record::{ReadingContacts, SideContacts};
use super::thick_piece::{ThickEdge, ThickPiece, ThickVertex};
use crate::plane::{Bounds, Pose2, Vec2};
use core::f64::consts::TAU;

/// Longest stretch of an edge that one cell takes (m).
const STRETCH: f64 = 0.06;
/// Headings between neighbouring cells at a vertex, and at one that stands for more than a few millimetres.
const VERTEX_HEADINGS: usize = 60;
const BUNDLE_HEADINGS: usize = 24;
/// Contacts at a vertex are taken together up to this size (m), or up to its own.
const TOGETHER: f64 = 4e-3;

/// Cells that hold every state in which the map explains the reading by contact within `near`, where that is known;
/// `touch` is sliced from a coarse table.
pub(super) fn initial_cells(
    level: &BoundaryLevel,
    near: Option<Bounds>,
    touch: &ReadingContacts,
    (record, late): (u32, PoseSlack),
) -> Vec<Parallelotope> {
    let mut cells = Vec::new();
    for bending in &touch.sides {
        let pieces = level.pieces(touch, bending);
        let mut lay = |piece: &ThickPiece| match piece {
            ThickPiece::Edge(edge) => along_edge(edge, touch, bending, record, &mut cells),
            ThickPiece::Vertex(vertex) => around_vertex(vertex, touch, bending, record, &mut cells),
        };
        match near {
            Some(bounds) => pieces.near(bounds, |piece, _| {
                lay(piece);
                false
            }),
            None => pieces.all.iter().for_each(&mut lay),
        }
    }
    let off = robot_slack(touch, late);
    cells.iter_mut().for_each(|cell| cell.inflate(off.place, off.turn));
    cells
}

/// How far the robot may be from where a base tells it that is where it is told on the robot.
pub(super) fn robot_slack(touch: &ReadingContacts, late: PoseSlack) -> PoseSlack {
    let arm = touch.robot_from_whisker.position().norm();
    PoseSlack::new(touch.base.place + arm * touch.base.turn, touch.base.turn).plus(late)
}

/// A cell of bases as a cell of robots.
pub(super) fn new_cell(center: Pose2, sides: [[f64; 3]; 3], touch: &ReadingContacts, record: u32) -> Parallelotope {
    let mut cell = Parallelotope {
        center,
        sides,
        anchor: record,
        seen: record,
        missed: 0,
        rest_until: 0,
        patience: 8,
        is_fresh: true,
    };
    // So far it is the whisker's base.
    cell.transport(touch.robot_from_whisker.inverse(), record);
    cell
}

fn along_edge(
    edge: &ThickEdge,
    touch: &ReadingContacts,
    bending: &SideContacts,
    record: u32,
    cells: &mut Vec<Parallelotope>,
) {
    let pieces = (edge.length / STRETCH).ceil().max(1.0);
    let half_length = 0.5 * edge.length / pieces;
    let normal = edge.along.perp();
    let lean = edge.slack + touch.friction_angle;
    let held = edge.concavity >= touch.holding;
    for entry in bending.slices[0].entries().iter().filter(|entry| held || !entry.inflected) {
        let psi = bending.side * entry.middle;
        let heading = edge.normal - psi;
        let contact = mirrored(entry, bending.side, entry.middle);
        let turned = |v: Vec2| v.rotated(heading);
        let (p, slope, thick) = (turned(contact.center), turned(contact.by_direction), turned(contact.by_moment));
        let half = contact.half;
        let size = [p.norm(), slope.norm(), thick.norm()];
        // The wall's normal may lean from the chord's: heading and base turn about the contact as they do with psi.
        let turn = half + lean;
        let rest = contact.radius
            + turn * (0.5 * size[0] * turn + size[1] * half + size[2] + contact.radius)
            + 2.0 * size[1] * half.min(lean)
            + edge.sagitta;
        let across = normal.dot(thick).abs() + rest;
        let along = half_length + edge.along.dot(thick).abs() + rest;
        let swing = p.perp() * turn - slope * half;
        let sides = [
            [edge.along.x * along, edge.along.y * along, 0.0],
            [normal.x * across, normal.y * across, 0.0],
            [swing.x, swing.y, -turn],
        ];
        for k in 0..pieces as usize {
            let touched = edge.start + edge.along * ((2 * k + 1) as f64 * half_length);
            let base = touched - p;
            let cell = new_cell(Pose2::new(base.x, base.y, heading), sides, touch, record);
            cells.push(cell);
        }
    }
}

fn around_vertex(
    vertex: &ThickVertex,
    touch: &ReadingContacts,
    bending: &SideContacts,
    record: u32,
    cells: &mut Vec<Parallelotope>,
) {
    let held = vertex.concavity >= touch.holding;
    let together = TOGETHER.max(2.0 * vertex.spread);
    let headings = if vertex.spread > 0.5 * TOGETHER { BUNDLE_HEADINGS } else { VERTEX_HEADINGS };
    let half = 0.5 * TAU / headings as f64;
    for k in 0..headings {
        let heading = (2 * k + 1) as f64 * half;
        let wide = (vertex.slack + touch.friction_angle + half).min(core::f64::consts::PI);
        let mut boxes: Vec<Bounds> = Vec::new();
        contacts(bending.side, &bending.slices[0], vertex.normal - heading, wide, |contact| {
            if held || !contact.inflected {
                gather(contact, together, &mut boxes)
            }
        });
        for bounds in boxes {
            let (center, wide) = ((bounds.min + bounds.max) * 0.5, (bounds.max - bounds.min) * 0.5);
            let rest = 0.5 * center.norm() * half * half + wide.norm() * half + vertex.spread + 1e-9;
            let turned = |v: Vec2| v.rotated(heading);
            let (x, y) = (turned(Vec2::new(wide.x + rest, 0.0)), turned(Vec2::new(0.0, wide.y + rest)));
            let p = turned(center);
            let swing = -p.perp() * half;
            let base = vertex.point - p;
            let sides = [[x.x, x.y, 0.0], [y.x, y.y, 0.0], [swing.x, swing.y, half]];
            cells.push(new_cell(Pose2::new(base.x, base.y, heading), sides, touch, record));
        }
    }
}

/// Adds the contacts of an entry to a rectangle that stays small, or to a new one.
fn gather(contact: &ContactEntry, together: f64, boxes: &mut Vec<Bounds>) {
    let of = |a: f64, b: f64| a.abs() * contact.half + b.abs() + contact.radius;
    let half =
        Vec2::new(of(contact.by_direction.x, contact.by_moment.x), of(contact.by_direction.y, contact.by_moment.y));
    let own = Bounds { min: contact.center - half, max: contact.center + half };
    let small = |b: Bounds| b.size().x.max(b.size().y) <= together;
    match boxes.iter_mut().find(|b| small(b.hull(own))) {
        Some(near) => *near = near.hull(own),
        None => boxes.push(own),
    }
}
