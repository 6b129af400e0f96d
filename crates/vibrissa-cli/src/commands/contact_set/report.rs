//! What there is to say about contact sets: words, JSON, table and figure.

use crate::commands::readings::{WhiskerReadings, words};
use crate::output::counted;
use serde_json::json;
use std::fmt::Write;
use vibrissa::Result;
use vibrissa::config::contact_set::{MEETING, NODES};
use vibrissa::figure::numbers::{fixed, significant};
use vibrissa::figure::{ContactFigure, contact_figure};
use vibrissa::flow::contact_set::{
    Contact, ContactRegion, ContactSet, Meeting, PlacedSet, Reading, Resolution, intersect_all,
};
use vibrissa::plane::Vec2;

/// Largest force that is told as a number (N): no whisker bears more.
const LARGEST_TOLD: f64 = 1e3;

/// Shapes in the figure.
const SHAPES: usize = 14;

/// The answer.
pub(super) struct Found<'a> {
    whiskers: &'a [WhiskerReadings],
    /// The curves of each exact reading, in the order of the readings, and the whisker that each belongs to.
    curves: Vec<(usize, ContactSet)>,
    /// Where the curves meet, when all readings are exact and there are several.
    meetings: Vec<Meeting>,
    /// The contacts of the first whisker that explain everything.
    region: ContactRegion,
}

impl<'a> Found<'a> {
    pub(super) fn new(whiskers: &'a [WhiskerReadings]) -> Result<Self> {
        let mut curves = Vec::new();
        for (index, whisker) in whiskers.iter().enumerate() {
            for reading in whisker.readings.iter().filter(|r| r.value.width() <= 0.0) {
                curves.push((index, ContactSet::new(&whisker.model, reading.sensor, reading.value.lo(), NODES)?));
            }
        }
        let first = &whiskers[0];
        let mut region = ContactRegion::new(&first.model, &first.readings, &Resolution::default())?;
        for other in &whiskers[1..] {
            let there = ContactRegion::new(&other.model, &other.readings, &Resolution::default())?;
            region = region.shared_with(&there, first.robot_from_whisker.between(other.robot_from_whisker));
        }
        let readings: usize = whiskers.iter().map(|w| w.readings.len()).sum();
        let placed: Vec<PlacedSet<'_>> = curves
            .iter()
            .map(|(w, set)| PlacedSet {
                set,
                frame_from_whisker: first.robot_from_whisker.between(whiskers[*w].robot_from_whisker),
            })
            .collect();
        let meetings =
            if curves.len() == readings && readings > 1 { intersect_all(&placed, MEETING) } else { Vec::new() };
        Ok(Self { whiskers, meetings, region, curves })
    }

    pub(super) fn is_empty(&self) -> bool {
        match self.curves.as_slice() {
            [(_, only)] if self.is_one_curve() => only.is_empty(),
            _ => self.region.is_empty(),
        }
    }

    /// Whether the answer is the curves of a single exact reading.
    fn is_one_curve(&self) -> bool {
        let readings: usize = self.whiskers.iter().map(|w| w.readings.len()).sum();
        readings == 1 && self.curves.len() == 1
    }

    fn readings(&self) -> impl Iterator<Item = (&WhiskerReadings, &Reading)> + '_ {
        self.whiskers.iter().flat_map(|w| w.readings.iter().map(move |r| (w, r)))
    }

    fn title(&self) -> String {
        let many = self.whiskers.len() > 1;
        let one =
            |(w, r): (&WhiskerReadings, &Reading)| if many { format!("{}: {}", w.name, words(r)) } else { words(r) };
        self.readings().map(one).collect::<Vec<_>>().join(", ")
    }

    pub(super) fn text(&self) -> String {
        let mut text = format!("contacts that explain {}, in the frame of {}\n", self.title(), self.whiskers[0].name);
        if self.is_one_curve() {
            let set = &self.curves[0].1;
            let regime = if set.model().is_small_angle() { ", small-angle model" } else { "" };
            let _ = writeln!(
                text,
                "{}{regime}; a contact is at most {:.4} mm off the listed curves",
                counted(set.curves.len(), "branch", "branches"),
                set.tolerance * 1e3
            );
            for curve in &set.curves {
                ends(&mut text, curve.contacts());
            }
            return text;
        }
        let components = self.region.components();
        let _ = writeln!(
            text,
            "{}, {:.4} mm² in all, covered by cells",
            counted(components.len(), "component", "components"),
            self.region.area() * 1e6
        );
        for component in &components {
            let places: Vec<Vec2> =
                component.iter().flat_map(|&i| self.region.cells[i].cover.corners().to_vec()).collect();
            let [x, y] = [|p: &Vec2| p.x, |p: &Vec2| p.y].map(|of| {
                let values = || places.iter().map(of);
                (values().fold(f64::INFINITY, f64::min) * 1e3, values().fold(f64::NEG_INFINITY, f64::max) * 1e3)
            });
            let [x, y] = [x, y].map(|(lo, hi)| format!("{} to {}", fixed(lo, 3), fixed(hi, 3)));
            let _ = writeln!(text, "  x {x} mm, y {y} mm");
        }
        for meeting in &self.meetings {
            let kind =
                if meeting.is_crossing { "the curves cross at" } else { "the curves touch or share a stretch around" };
            let _ = writeln!(
                text,
                "{kind} ({:.6}, {:.6}) mm, extent {:.3} mm{}",
                meeting.position.x * 1e3,
                meeting.position.y * 1e3,
                meeting.extent * 1e3,
                if self.whiskers.len() == 1 && !meeting.is_one_shape() {
                    ", but with two different shapes"
                } else {
                    ""
                }
            );
        }
        text
    }

    pub(super) fn json(&self) -> String {
        let readings = self.readings().map(
            |(w, r)| json!({ "whisker": w.name, "sensor": r.sensor.word(), "lo": r.value.lo(), "hi": r.value.hi() }),
        );
        let curves = self.curves.iter().map(|(w, set)| {
            let branches: Vec<Vec<_>> = set.curves.iter().map(|c| c.contacts().iter().map(contact).collect()).collect();
            json!({
                "whisker": self.whiskers[*w].name, "sensor": set.sensor.word(), "value": set.value,
                "small_angle": set.model().is_small_angle(), "tolerance": set.tolerance, "branches": branches,
            })
        });
        let meetings = self.meetings.iter().map(|m| {
            json!({
                "x": m.position.x, "y": m.position.y, "extent": m.extent, "crossing": m.is_crossing,
                "one_shape": m.is_one_shape(), "first": contact(&m.first), "second": contact(&m.second),
            })
        });
        let components = self.region.components();
        let cells = self.region.cells.iter().map(|cell| {
            json!({ "contact": contact(&cell.contact), "cover": cell.cover.corners().iter().map(|p| [p.x, p.y]).collect::<Vec<_>>() })
        });
        let value = json!({
            "readings": readings.collect::<Vec<_>>(),
            "curves": curves.collect::<Vec<_>>(),
            "meetings": meetings.collect::<Vec<_>>(),
            "region": { "area": self.region.area(), "components": components.len(), "cells": cells.collect::<Vec<_>>() },
        });
        format!("{value:#}\n")
    }

    /// Contacts along curves, or the middles of cells with their radius; SI.
    pub(super) fn csv(&self) -> String {
        let mut text = String::from("set,branch,x,y,s_a,phi_a,force,moment,radius\n");
        let mut row = |set: &str, branch: usize, c: &Contact, radius: f64| {
            let numbers = [c.position.x, c.position.y, c.s_a, c.phi_a, c.force, c.moment, radius];
            let _ = writeln!(text, "{set},{branch},{}", numbers.map(|v| v.to_string()).join(","));
        };
        for (_, set) in &self.curves {
            for (branch, curve) in set.curves.iter().enumerate() {
                curve.contacts().iter().for_each(|c| row(set.sensor.word(), branch, c, set.tolerance));
            }
        }
        for meeting in &self.meetings {
            row("meeting", 0, &meeting.first, 0.5 * meeting.extent);
        }
        if !self.is_one_curve() {
            for (branch, component) in self.region.components().iter().enumerate() {
                component
                    .iter()
                    .for_each(|&i| row("region", branch, &self.region.cells[i].contact, self.region.cells[i].radius));
            }
        }
        text
    }

    pub(super) fn figure(&self) -> String {
        let model = &self.whiskers[0].model;
        let contacts: Vec<Contact> = if self.is_one_curve() {
            self.curves[0].1.curves.iter().flat_map(|c| c.contacts().to_vec()).collect()
        } else {
            self.region.cells.iter().map(|cell| cell.contact).collect()
        };
        let step = contacts.len().div_ceil(SHAPES).max(1);
        let own = if self.is_one_curve() { self.curves[0].1.model() } else { model };
        let shape = |c: &Contact| own.shape(c, 81);
        let base = self.whiskers[0].robot_from_whisker;
        let place = |w: usize, p: Vec2| base.between(self.whiskers[w].robot_from_whisker).transform_point(p);
        let figure = ContactFigure {
            title: format!("Contacts for {}", self.title()),
            length: model.length(),
            shapes: contacts.iter().step_by(step).map(shape).collect(),
            curves: self
                .curves
                .iter()
                .flat_map(|(w, set)| {
                    let curves = set.curves.iter().map(|c| c.points().iter().map(|&p| place(*w, p)).collect());
                    curves.map(|points| (words(&Reading::exact(set.sensor, set.value)), points)).collect::<Vec<_>>()
                })
                .collect(),
            region: if self.is_one_curve() {
                Vec::new()
            } else {
                self.region.cells.iter().map(|cell| cell.cover.corners().to_vec()).collect()
            },
            points: self.meetings.iter().map(|m| m.position).collect(),
        };
        contact_figure(&figure)
    }
}

fn ends(text: &mut String, contacts: &[Contact]) {
    let (Some(a), Some(b)) = (contacts.first(), contacts.last()) else { return };
    for (word, c) in [("  from", a), ("    to", b)] {
        // Towards the base a force of any size explains a moment.
        let force =
            if c.force > LARGEST_TOLD { "  above 1 kN".into() } else { format!("{:>10} N", significant(c.force, 4)) };
        let _ = writeln!(
            text,
            "{word} ({:>8}, {:>8}) mm   s_a {:7.3} mm   phi_a {:>8} deg   F {force}   M(0) {:>8} mN m",
            fixed(c.position.x * 1e3, 3),
            fixed(c.position.y * 1e3, 3),
            c.s_a * 1e3,
            fixed(c.phi_a.to_degrees(), 3),
            significant(c.moment * 1e3, 4)
        );
    }
}

fn contact(c: &Contact) -> serde_json::Value {
    json!({ "x": c.position.x, "y": c.position.y, "s_a": c.s_a, "phi_a": c.phi_a, "force": c.force, "moment": c.moment })
}
