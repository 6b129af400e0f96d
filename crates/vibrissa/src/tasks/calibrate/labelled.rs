//! Labelled contacts: readings beside the contact point that caused them, and what the beam says about each.

use crate::beam::rod::Status;
use crate::beam::{Bend, Load, Rod, Whisker, deflection_per_force};
use crate::io::log::foreign::Recording;
use crate::plane::Vec2;
use crate::{Error, Result};
use vibrissa_core::math;

/// Readings with known contact points.
#[derive(Clone, Debug, PartialEq)]
pub struct Labelled {
    /// The file, for messages.
    pub source: String,
    /// Contact points in the whisker frame (m); `y = 0` is no contact. With [`Labelled::angles`], `y` is the distance from the
    /// undeflected whisker's axis.
    pub contacts: Vec<Vec2>,
    /// The angle of each contact about the whisker's axis (rad), from +y towards +z; empty where all contacts are in the x-y plane.
    pub angles: Vec<f64>,
    /// Names of the raw inputs: `bx,by,bz` or `ax,ay,az`, as far as they are there.
    pub inputs: Vec<String>,
    /// The raw readings of each contact, in the order of the inputs.
    pub readings: Vec<Vec<f64>>,
    /// Measured moments (N m), where the recording has them.
    pub moments: Option<Vec<f64>>,
}

/// A contact as the beam explains it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Explained {
    /// The index of the contact.
    pub row: usize,
    /// Moment about the base in the whisker's x-y plane (N m).
    pub moment: f64,
    /// Moment across it (N m), positive for a push towards +z.
    pub across: f64,
    /// How far the tip retreats along the undeflected whisker (m).
    pub retreat: f64,
}

impl Explained {
    /// The size of both moments (N m).
    #[must_use]
    pub fn size(&self) -> f64 {
        math::hypot(self.moment, self.across)
    }
}

impl Labelled {
    /// The labelled contacts of a recording with columns `x,y` or `x,y,z` and raw readings or `moment`.
    ///
    /// # Errors
    ///
    /// A recording without these columns.
    pub fn from_recording(recording: &Recording) -> Result<Self> {
        if recording.column("theta").is_some() {
            return Err(Error::data("the log has a column `theta`: it is a robot's way, not contact points")
                .in_file(&recording.source)
                .allowed("x,y of the contact in the whisker frame (m), beside its readings")
                .remedy("record contacts at known points, or calibrate from taps with --taps"));
        }
        let (x, y) = (recording.require("x")?, recording.require("y")?);
        let z = recording.column("z").filter(|z| z.iter().any(|z| *z != 0.0));
        let contact = |row: usize| match z {
            Some(z) => Vec2::new(x[row], math::hypot(y[row], z[row])),
            None => Vec2::new(x[row], y[row]),
        };
        let raw = [["bx", "by", "bz"], ["ax", "ay", "az"]];
        let held =
            |names: &[&'static str; 3]| names.iter().copied().filter(|n| recording.column(n).is_some()).collect();
        let mut choices = raw.iter().map(held).filter(|names: &Vec<&str>| !names.is_empty());
        let names: Vec<&str> = choices.next().unwrap_or_default();
        let moments = recording.column("moment").map(<[f64]>::to_vec);
        if choices.next().is_some() {
            return Err(Error::data("the recording has both flux and counts")
                .in_file(&recording.source)
                .remedy("remove the columns of one of them"));
        }
        if names.is_empty() && moments.is_none() {
            return Err(Error::data("the recording has no readings beside its contacts")
                .in_file(&recording.source)
                .allowed("bx,by,bz (T), ax,ay,az (counts) or moment (N m)"));
        }
        let columns: Vec<&[f64]> = names.iter().filter_map(|name| recording.column(name)).collect();
        Ok(Self {
            source: recording.source.clone(),
            contacts: (0..x.len()).map(contact).collect(),
            angles: z.map_or_else(Vec::new, |z| y.iter().zip(z).map(|(y, z)| math::atan2(*z, *y)).collect()),
            inputs: names.iter().map(|&name| name.to_owned()).collect(),
            readings: (0..x.len()).map(|row| columns.iter().map(|column| column[row]).collect()).collect(),
            moments,
        })
    }

    /// What `whisker` says about each contact in point mode \[routray, section "Sensor Calibration"\]; contacts that it
    /// cannot reach are left out.
    ///
    /// # Errors
    ///
    /// Data: a whisker that makes no sense.
    pub fn explain(&self, whisker: &Whisker) -> Result<Vec<Explained>> {
        let rod = Rod::new(whisker)?;
        let mut explained = Vec::with_capacity(self.contacts.len());
        for (row, &contact) in self.contacts.iter().enumerate() {
            if contact.y.abs() <= 0.0 {
                explained.push(Explained { row, moment: 0.0, across: 0.0, retreat: 0.0 });
            } else if let Some(bend) = bend_to(&rod, whisker, contact)? {
                let retreat = -bend.tip_displacement(whisker.length).x;
                let (across, along) = self.angles.get(row).map_or((0.0, 1.0), |angle| math::sin_cos(*angle));
                explained.push(Explained { row, moment: bend.moment * along, across: bend.moment * across, retreat });
            }
        }
        Ok(explained)
    }
}

/// The shape of least slope that is pushed to the contact point by a normal load.
fn bend_to(rod: &Rod, whisker: &Whisker, contact: Vec2) -> Result<Option<Bend>> {
    let distance = contact.norm();
    if !distance.is_finite() || distance <= 0.0 || distance > whisker.length * (1.0 + 1e-9) {
        return Ok(None);
    }
    let straight = Whisker { curvature: 0.0, curvature_rise: Default::default(), ..*whisker };
    let force = contact.y / deflection_per_force(&straight, distance.min(whisker.length))?;
    let start = rod.force_mode(force, distance.min(whisker.length), Load::Normal)?;
    if let Some(start) = start.first() {
        let followed = rod.point_from(contact, Load::Normal, start)?;
        if let (Status::Converged, Some(bend)) = (followed.status, followed.bend) {
            // The force must push, not pull: another branch may have been met on the way.
            if bend.force * contact.y > 0.0 && bend.phi_a.abs() < core::f64::consts::FRAC_PI_2 {
                return Ok(Some(bend));
            }
        }
    }
    let bends = rod.point_mode(contact, Load::Normal)?;
    Ok(bends.into_iter().find(|bend| bend.force * contact.y > 0.0))
}
