//! The initial cover: cells around every state that one reading allows, anywhere on the map (set inversion,
//! \[jaulin2001applied, ch. 3\]).

use super::contact_tables::START_TABLE;
use super::contractor::{BoundaryLevel, ContactEntry, contacts, mirrored};
use super::errors::PoseSlack;
use super::parallelotope::Parallelotope;
use super::record::{ReadingContacts, SideContacts};
use super::thick_piece::{ThickEdge, ThickPiece, ThickVertex};
use super::{PossibleSet, two_contact_cover};
use crate::WorkBudget;
use crate::plane::{Bounds, Pose2, Vec2};
use crate::sets::Interval;
use crate::world::Map;
use core::f64::consts::TAU;

/// Longest stretch of an edge that one cell takes (m).
const STRETCH: f64 = 0.06;
/// Headings between neighbouring cells at a vertex, and at one that stands for more than a few millimetres.
const VERTEX_HEADINGS: usize = 60;
const BUNDLE_HEADINGS: usize = 24;
/// Contacts at a vertex are taken together up to this size (m), or up to its own.
const TOGETHER: f64 = 4e-3;

/// What a piece of boundary costs, and a cell.
const PIECE_COST: usize = 20;
const CELL_COST: usize = 1;

/// The first cells in the making: what each whisker's reading that needs a contact allows, of which those that leave fewest are kept.
/// Of any `tolerate + 1` readings one is true.
#[derive(Clone, Debug)]
pub(super) struct InitialCover {
    moments: Vec<Interval>,
    whisker: usize,
    /// The whisker's reading, and the side and the piece of boundary that come next.
    touch: Option<ReadingContacts>,
    side: usize,
    piece: usize,
    cells: Vec<Parallelotope>,
    laid: Vec<Vec<Parallelotope>>,
}

impl InitialCover {
    /// Before the first whisker.
    pub(super) fn new(moments: &[Interval]) -> Self {
        let moments = moments.to_vec();
        Self { moments, whisker: 0, touch: None, side: 0, piece: 0, cells: Vec::new(), laid: Vec::new() }
    }

    /// Lays cells on the next pieces for every state in which they explain the reading by contact within `near`, where that is
    /// known; whether no piece is left. The reading is sliced from a coarse table.
    fn lay(
        &mut self,
        level: &BoundaryLevel,
        near: Option<Bounds>,
        touch: &ReadingContacts,
        record: u32,
        budget: &mut WorkBudget,
    ) -> bool {
        while let Some(bending) = touch.sides.get(self.side) {
            let pieces = level.pieces(touch, bending);
            let cells = &mut self.cells;
            let mut lay = |piece: &ThickPiece| {
                let before = cells.len();
                match piece {
                    ThickPiece::Edge(edge) => along_edge(edge, touch, bending, record, cells),
                    ThickPiece::Vertex(vertex) => around_vertex(vertex, touch, bending, record, cells),
                }
                budget.spend(PIECE_COST + CELL_COST * (cells.len() - before));
                budget.is_spent()
            };
            match near {
                Some(bounds) => pieces.near(bounds, |piece, _| {
                    lay(piece);
                    false
                }),
                None => {
                    let left = &pieces.all[self.piece..];
                    if let Some(last) = left.iter().position(&mut lay) {
                        self.piece += last + 1;
                        return false;
                    }
                }
            }
            (self.side, self.piece) = (self.side + 1, 0);
        }
        true
    }
}

impl PossibleSet {
    /// Goes on with the first cells; whether they are laid, or there is nothing to lay.
    pub(super) fn lay_some(&mut self, map: &Map, cover: &mut InitialCover, budget: &mut WorkBudget) -> bool {
        let record = self.records.len() as u32 - 1;
        while let (Some(probe), Some(moment)) = (self.probes.get(cover.whisker), cover.moments.get(cover.whisker)) {
            if budget.is_spent() {
                return false;
            }
            if !moment.contains(0.0) {
                let tables = &probe.tables[START_TABLE..];
                let new = || ReadingContacts::new(&probe.whisker, tables, moment.lo(), moment.hi());
                let touch = cover.touch.take().unwrap_or_else(new);
                let (near, late) = (self.near(&probe.whisker), self.records[record as usize].late);
                if !cover.lay(&self.ground.clustered, near, &touch, record, budget) {
                    cover.touch = Some(touch);
                    return false;
                }
                let mut cells = std::mem::take(&mut cover.cells);
                let off = robot_slack(&touch, late);
                cells.iter_mut().for_each(|cell| cell.inflate(off.place, off.turn));
                if let Some(two) = self.two_contacts.as_ref().filter(|_| self.is_late(record)) {
                    cells.extend(two_contact_cover::initial_cells(map, two, near, &touch, (record, late)));
                }
                cover.laid.push(cells);
            }
            (cover.whisker, cover.side) = (cover.whisker + 1, 0);
        }
        self.start(std::mem::take(&mut cover.laid));
        true
    }

    /// Begins with the cells that leave fewest.
    fn start(&mut self, mut laid: Vec<Vec<Parallelotope>>) {
        laid.sort_by_key(Vec::len);
        laid.truncate(self.options.tolerate + 1 - self.starts);
        if !laid.is_empty() {
            self.starts += laid.len();
            self.started_at = self.records.len() as u32 - 1;
            for cells in laid {
                // Where there are none yet, without a copy: there may be hundreds of thousands.
                if self.cells.is_empty() { self.cells = cells } else { self.cells.extend(cells) }
            }
        }
        if self.starts == 0 {
            return;
        }
        let cells = std::mem::take(&mut self.cells);
        self.cells = cells.into_iter().filter_map(|cell| self.with_prior_knowledge(cell)).collect();
        self.untried = self.cells.len();
        // One whisker's reading alone rules out none of the cells that were laid for it.
        if self.has_started() && self.probes.len() > 1 {
            self.begin_turns();
        }
    }
}

/// All cells that one reading lays, at once.
#[cfg(test)]
pub(super) fn initial_cells(
    level: &BoundaryLevel,
    near: Option<Bounds>,
    touch: &ReadingContacts,
    (record, late): (u32, PoseSlack),
) -> Vec<Parallelotope> {
    let mut cover = InitialCover::new(&[]);
    cover.lay(level, near, touch, record, &mut WorkBudget::unlimited());
    let off = robot_slack(touch, late);
    cover.cells.iter_mut().for_each(|cell| cell.inflate(off.place, off.turn));
    cover.cells
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
