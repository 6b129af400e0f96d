//! What viewers draw: lines with a width and a colour.

use crate::plane::Vec2;

/// A chain of points (m).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Line {
    /// The points, in the frame of the message.
    pub points: Vec<Vec2>,
    /// Whether the last point is joined to the first.
    pub closed: bool,
}

/// Lines of one look.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LineSet {
    /// The name by which viewers show and hide them.
    pub name: &'static str,
    /// Red, green, blue and opacity, from 0 to 1.
    pub color: [f32; 4],
    /// Width of the lines (m).
    pub width: f64,
    /// Height over the plane at which they are drawn (m), so that what matters lies on top.
    pub height: f64,
    /// The lines.
    pub lines: Vec<Line>,
}

impl Line {
    /// The ends of each piece.
    pub(crate) fn pieces(&self) -> impl Iterator<Item = [Vec2; 2]> {
        let last = self.closed.then(|| Some([*self.points.last()?, *self.points.first()?])).flatten();
        self.points.windows(2).map(|w| [w[0], w[1]]).chain(last)
    }
}
