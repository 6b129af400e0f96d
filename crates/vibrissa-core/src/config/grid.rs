//! How grid maps are read.

/// How boundaries are traced from grid maps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridOptions {
    /// How far lines may miss the boundary points of grey cells (cells): a few times what 8 bits of grey leave open.
    pub grey_tolerance: f64,
    /// The same where cells are all solid or all free (cells): the stairs of a slanting wall, from crest to crest.
    pub sharp_tolerance: f64,
    /// Whether unknown cells are free: the robot may have been where nobody looked, and walls then have two sides.
    pub unknown_is_free: bool,
}

impl Default for GridOptions {
    fn default() -> Self {
        Self { grey_tolerance: 0.05, sharp_tolerance: 0.8, unknown_is_free: false }
    }
}
