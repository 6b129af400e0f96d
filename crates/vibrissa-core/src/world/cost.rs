//! What the boundaries of a map cost, told before memory is taken for them.

use crate::config::budgets::{MOST_BOUNDARIES, MOST_FLAT_EDGES, MOST_PIECES};
use crate::config::limits::FLATTEN_TOLERANCE;
use crate::plane::Segment;
use crate::{Error, Result};

/// What the boundaries of a map that is being read have cost so far; see [`crate::config::budgets`].
#[derive(Clone, Copy, Debug, Default)]
pub struct MapCost {
    boundaries: usize,
    pieces: usize,
    edges: usize,
}

impl MapCost {
    /// Adds an outline or a wall of these pieces.
    ///
    /// # Errors
    ///
    /// More boundaries, pieces, or lines within a micrometre of the curves than a map may have.
    pub fn add(&mut self, pieces: &[Segment]) -> Result<()> {
        // Each piece has at least one line, so that a count of pieces alone tells when it is too many.
        self.pieces = self.pieces.saturating_add(pieces.len());
        self.check()?;
        self.edges += pieces.iter().map(|piece| piece.flat_parts(FLATTEN_TOLERANCE)).sum::<usize>();
        self.boundaries += 1;
        self.check()
    }

    /// Adds a chain of so many straight lines.
    ///
    /// # Errors
    ///
    /// As [`MapCost::add`].
    pub fn add_lines(&mut self, lines: usize) -> Result<()> {
        self.pieces = self.pieces.saturating_add(lines);
        self.edges = self.edges.saturating_add(lines);
        self.boundaries += 1;
        self.check()
    }

    fn check(&self) -> Result<()> {
        let too_many = |what: &str, value: usize, most: usize, remedy: &str| {
            Err(Error::data(what).value(format!("{value} or more")).allowed(format!("up to {most}")).remedy(remedy))
        };
        let smaller = "cut out the part that the robot can be in, or simplify the outlines";
        if self.pieces > MOST_PIECES {
            return too_many("the map has too many pieces of lines and curves", self.pieces, MOST_PIECES, smaller);
        }
        if self.edges > MOST_FLAT_EDGES {
            let unit = "is it in millimetres where metres are due? Else cut out the part that the robot can be in";
            let what = "the map's curves are too long to be followed by lines within a micrometre";
            return too_many(what, self.edges, MOST_FLAT_EDGES, unit);
        }
        if self.boundaries > MOST_BOUNDARIES {
            return too_many("the map has too many boundaries", self.boundaries, MOST_BOUNDARIES, smaller);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::MapCost;
    use crate::config::budgets::{MOST_BOUNDARIES, MOST_PIECES};
    use crate::plane::{Segment, Vec2};

    #[test]
    fn what_is_beyond_a_budget_is_told_with_the_allowed_value() {
        let mut cost = MapCost::default();
        assert!(cost.add_lines(MOST_PIECES).is_ok());
        let told = cost.add_lines(1).unwrap_err().to_string();
        assert!(told.contains(&format!("up to {MOST_PIECES}")) && told.contains("help: "), "{told}");
        let mut cost = MapCost::default();
        assert!((0..MOST_BOUNDARIES).all(|_| cost.add_lines(1).is_ok()) && cost.add_lines(1).is_err());
    }

    #[test]
    fn a_curve_costs_as_many_lines_as_follow_it() {
        let far = |size: f64| {
            Segment::Cubic([(0.0, 0.0), (size, size), (-size, size), (0.0, 0.1)].map(|(x, y)| Vec2::new(x, y)))
        };
        // A bend of a metre takes a few thousand lines, one of 90 km as many as a piece may have.
        assert!(MapCost::default().add(&vec![far(1.0); 200]).is_ok());
        let told = MapCost::default().add(&vec![far(9e4); 200]).unwrap_err().to_string();
        assert!(told.contains("micrometre") && told.contains("metres are due"), "{told}");
    }
}
