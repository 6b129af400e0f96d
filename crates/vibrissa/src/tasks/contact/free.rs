//! What a free whisker reads: noise around its zero, which is followed as fast as it may drift.
//!
//! The zero that is followed never lies farther from the true one than the true one lay at first, or than the noise does, and two steps of
//! the drift: while it is off by more than the noise every free reading moves it to the right side. So no free reading is taken for a
//! contact, and no contact is missed whose reading is beyond that.

use crate::world::MountedWhisker;

/// The zero of a free whisker.
#[derive(Clone, Copy, Debug)]
pub(super) struct FreeLevel {
    /// How far a free whisker's reading may be from its zero (N m).
    noise: f64,
    /// How far the zero may be from the one that is followed (N m).
    off: f64,
    /// How fast the zero may drift (N m/s).
    drift: f64,
    /// The zero as it was followed (N m); 0 where it may not drift.
    zero: f64,
    /// How much farther off it may be since it was followed step by step (N m).
    behind: f64,
    /// When the whisker was last free (s).
    since: Option<f64>,
}

impl FreeLevel {
    pub(super) fn new(whisker: &MountedWhisker) -> Self {
        let (noise, drift) = (whisker.noise.largest_free_reading(), whisker.errors.zero_drift);
        let off = if drift > 0.0 { whisker.errors.zero.max(noise) } else { whisker.errors.zero };
        Self { noise, off, drift, zero: 0.0, behind: 0.0, since: None }
    }

    /// Whether a reading (N m) at this time (s) is that of a whisker in contact; otherwise the zero follows it.
    pub(super) fn is_contact(&mut self, t: f64, reading: f64) -> bool {
        let drifted = self.drift * (t - *self.since.get_or_insert(t)).max(0.0);
        let away = reading - self.zero;
        if away.abs() > self.noise + self.off + self.behind + drifted {
            return true;
        }
        self.behind = if away.abs() <= drifted { 0.0 } else { self.behind.max(2.0 * drifted) };
        self.zero += away.clamp(-drifted, drifted);
        self.since = Some(t);
        false
    }

    /// A reading without the zero (N m).
    pub(super) fn moment(&self, reading: f64) -> f64 {
        reading - self.zero
    }
}
