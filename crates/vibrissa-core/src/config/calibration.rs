//! How recordings are measured and curves fitted to them.

/// How taps are found in a recording and their onsets measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TapOptions {
    /// Least height of a tap over the noise at rest, in standard deviations.
    pub prominence: f64,
    /// Least height of a tap relative to the recording's largest: below lie the swings before and after a tap.
    pub threshold: f64,
    /// How long the reading rests before a tap is over (s).
    pub settle: f64,
    /// Beginning of the stretch before a tap that gives the level of rest (s before the tap): four swings of the shaft.
    pub rest_from: f64,
    /// Its end (s before the tap).
    pub rest_until: f64,
    /// Shortest length over which the ramp's slope is taken (s): three ripples of a touched shaft.
    pub shortest_ramp: f64,
    /// Longest length (s): five hundredths of a second after the onset no stroke is a ramp any more.
    pub longest_ramp: f64,
    /// How many lengths are averaged.
    pub ramp_lengths: usize,
    /// Most that the slopes over these lengths may differ, as a share: what bends more is no ramp.
    pub most_spread: f64,
}

impl Default for TapOptions {
    fn default() -> Self {
        Self {
            prominence: 8.0,
            threshold: 0.25,
            settle: 10e-3,
            rest_from: 190e-3,
            rest_until: 19e-3,
            shortest_ramp: 32.5e-3,
            longest_ramp: 45e-3,
            ramp_lengths: 6,
            most_spread: 0.15,
        }
    }
}

impl TapOptions {
    /// The lengths over which the slope is taken, evenly spaced (s).
    pub fn ramps(&self) -> impl Iterator<Item = f64> {
        let (shortest, span) = (self.shortest_ramp, self.longest_ramp - self.shortest_ramp);
        let last = self.ramp_lengths.saturating_sub(1).max(1) as f64;
        (0..self.ramp_lengths).map(move |i| shortest + span * i as f64 / last)
    }
}

/// How the steps of a staircase recording are measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StaircaseOptions {
    /// Where the level before a step is taken: at the end of the step before, in dwells (its first part still creeps).
    pub before: [f64; 2],
    /// Where the level after a step is taken, in dwells: the first third of a dwell still holds the move.
    pub after: [f64; 2],
    /// Distances that differ by less are one and the same (m): rigs tilt by hundredths of a millimetre.
    pub same_distance: f64,
    /// Fewest rows that give a level.
    pub fewest_rows: usize,
}

impl Default for StaircaseOptions {
    fn default() -> Self {
        Self { before: [0.7, 0.98], after: [0.35, 0.6], same_distance: 1e-3, fewest_rows: 6 }
    }
}

/// How the curve from raw readings to moments is fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveOptions {
    /// Highest degree of the polynomial: a magnet's field is bent, but not in waves.
    pub most_degree: usize,
    /// Fewest labelled contacts: blocks of eight in ten parts leave too little of less.
    pub fewest_contacts: usize,
}

impl Default for CurveOptions {
    fn default() -> Self {
        Self { most_degree: 5, fewest_contacts: 20 }
    }
}
