//! One boundary of a map: its curve, its role, and on which side it is free.

use super::{Course, PieceCourse};
use crate::config::limits::{FLATTEN_TOLERANCE, LARGEST_COORDINATE};
use crate::plane::{Curve, Segment, SegmentTree, Vec2};
use crate::{Error, Result};

/// What a boundary means for the space beside it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// The outline of free space: free inside.
    Arena,
    /// The outline of something solid, or of a hole in it.
    Obstacle,
    /// A thin line, solid on both sides.
    Wall,
}

impl Role {
    /// The words that name the roles in files.
    pub const WORDS: [&str; 3] = ["arena", "obstacle", "wall"];

    /// The role named by exactly this word.
    #[must_use]
    pub fn from_word(word: &str) -> Option<Self> {
        match word {
            "arena" => Some(Self::Arena),
            "obstacle" => Some(Self::Obstacle),
            "wall" => Some(Self::Wall),
            _ => None,
        }
    }

    /// The word that names the role in files.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Arena => "arena",
            Self::Obstacle => "obstacle",
            Self::Wall => "wall",
        }
    }
}

/// A curve of the map, travelled so that free space lies on its left; a wall is solid towards both sides.
#[derive(Clone, Debug, PartialEq)]
pub struct Boundary {
    role: Role,
    curve: Curve,
    name: Option<String>,
    /// Whether the curve was given the other way round.
    is_turned: bool,
    course: Option<Course>,
}

/// A fault of a curve and the corner (of the curve's flattened form) at which it shows.
#[derive(Clone, Debug)]
pub struct CurveFault {
    /// The corner (m), where one is at fault.
    pub place: Option<Vec2>,
    /// What is wrong.
    pub error: Error,
}

impl Boundary {
    /// An arena's outline (free inside), an obstacle's outline (free outside) or a wall, turned so that free space is
    /// on the left.
    ///
    /// # Errors
    ///
    /// Outlines that are open, cross or touch themselves, or enclose no area; coordinates beyond 1e5 m.
    pub fn new(role: Role, curve: Curve, name: Option<String>) -> Result<Self> {
        Self::checked(role, curve, false, name).map_err(|fault| fault.error)
    }

    /// The outline of a hole in an obstacle: free inside, like an arena, but cut out of the obstacle around it.
    ///
    /// # Errors
    ///
    /// As [`Boundary::new`].
    pub fn obstacle_hole(curve: Curve, name: Option<String>) -> Result<Self> {
        Self::checked(Role::Obstacle, curve, true, name).map_err(|fault| fault.error)
    }

    /// A boundary for readers of files, who tell the line of the corner at fault; `hole` is that of an obstacle.
    ///
    /// # Errors
    ///
    /// As [`Boundary::new`], with the corner at which it shows.
    pub fn checked(
        role: Role,
        curve: Curve,
        hole: bool,
        name: Option<String>,
    ) -> core::result::Result<Self, CurveFault> {
        check_size(&curve)?;
        if role == Role::Wall {
            return Ok(Self { role, curve, name, is_turned: false, course: None });
        }
        check_outline(role, &curve)?;
        let free_inside = (role == Role::Arena) != hole;
        let is_turned = (curve.signed_area() > 0.0) != free_inside;
        let curve = if is_turned { curve.reversed() } else { curve };
        Ok(Self { role, curve, name, is_turned, course: None })
    }

    /// The same known no more exactly than this, piece by piece of the curve as it was given.
    ///
    /// # Errors
    ///
    /// Another number of pieces than the curve has.
    pub fn with_course(self, course: Course) -> Result<Self> {
        let (told, has) = (course.pieces().len(), self.curve.segments().len());
        if told != has {
            return Err(Error::data("a band of another number of pieces than the boundary has")
                .value(told.to_string())
                .allowed(has.to_string())
                .remedy("give one for each piece between two points"));
        }
        let course = Some(if self.is_turned { course.reversed() } else { course });
        Ok(Self { course, ..self })
    }

    /// How exactly it is known, piece by piece of [`Boundary::curve`]; none where it is known exactly.
    #[must_use]
    pub fn course(&self) -> Option<&Course> {
        self.course.as_ref()
    }

    /// What is known of one piece of its curve; none where it is known exactly.
    #[must_use]
    pub fn piece_course(&self, segment: usize) -> Option<PieceCourse> {
        self.course.as_ref().and_then(|course| course.pieces().get(segment).copied())
    }

    /// What the boundary means.
    #[must_use]
    pub fn role(&self) -> Role {
        self.role
    }

    /// The curve, with free space on its left.
    #[must_use]
    pub fn curve(&self) -> &Curve {
        &self.curve
    }

    /// The name given in the file, where there is one.
    #[must_use]
    pub fn name(&self) -> Option<&str> {
        self.name.as_deref()
    }

    /// Whether both sides are free: true for walls.
    #[must_use]
    pub fn is_two_sided(&self) -> bool {
        self.role == Role::Wall
    }
}

fn show(p: Vec2) -> String {
    // To the nanometre: finer digits are roundings of the reader.
    let short = |v: f64| if v.abs() < 1e12 { ((v * 1e9).round() / 1e9).to_string() } else { format!("{v:e}") };
    format!("({}, {})", short(p.x), short(p.y))
}

fn check_size(curve: &Curve) -> core::result::Result<(), CurveFault> {
    match beyond_maps(curve.segments()) {
        Some(p) => Err(CurveFault { place: Some(p), error: out_of_range(p) }),
        None => Ok(()),
    }
}

/// A control point that lies further out than maps go.
pub fn beyond_maps(segments: &[Segment]) -> Option<Vec2> {
    let too_far = |p: &&Vec2| p.x.abs().max(p.y.abs()) > LARGEST_COORDINATE;
    segments.iter().flat_map(Segment::control_points).find(too_far).copied()
}

/// The error for a coordinate that no map in metres holds.
#[must_use]
pub fn out_of_range(p: Vec2) -> Error {
    Error::data("coordinate out of range")
        .value(show(p))
        .allowed(format!("-{LARGEST_COORDINATE} to {LARGEST_COORDINATE} m"))
        .remedy("map coordinates are metres in a local frame, not millimetres, degrees or a geographic grid")
}

fn check_outline(role: Role, curve: &Curve) -> core::result::Result<(), CurveFault> {
    let fault = |place: Option<Vec2>, error: Error| Err(CurveFault { place, error });
    let word = role.word();
    if !curve.is_closed() {
        let error = Error::data(format!("the outline of this {word} is open"))
            .remedy("close it, or make it a wall if it is a thin line");
        return fault(None, error);
    }
    let corners = curve.flatten(FLATTEN_TOLERANCE);
    if let Some(p) = repeated_corner(&corners[1..]) {
        let error = Error::data(format!("the outline of this {word} passes twice through one point"))
            .value(show(p))
            .remedy("split it into separate polygons there");
        return fault(Some(p), error);
    }
    let edges: Vec<[Vec2; 2]> = corners.windows(2).map(|w| [w[0], w[1]]).collect();
    if let Some(hit) = SegmentTree::new(&edges).self_intersections().first() {
        let edge = |i: usize| format!("the edge {} to {}", show(edges[i][0]), show(edges[i][1]));
        let error = Error::data(format!("the outline of this {word} crosses itself"))
            .value(format!("at {}, where {} meets {}", show(hit.point), edge(hit.first), edge(hit.second)))
            .remedy("reorder its points so that they go round once, or split it into separate polygons");
        return fault(Some(edges[hit.first][0]), error);
    }
    let size = curve.bounds().size();
    if curve.signed_area().abs() <= 1e-12 * size.norm_squared() {
        let error = Error::data(format!("the outline of this {word} encloses no area"))
            .remedy("give at least three points that are not on one line, or make it a wall");
        return fault(None, error);
    }
    Ok(())
}

/// A corner that a ring visits twice, in order of coordinates.
fn repeated_corner(corners: &[Vec2]) -> Option<Vec2> {
    let mut sorted = corners.to_vec();
    sorted.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    sorted.windows(2).find(|w| w[0] == w[1]).map(|w| w[0])
}
