//! The map: boundaries, and the questions that localization asks of them.

use super::unknown::UnknownZones;
use super::{Boundary, MapCost, PieceCourse, Role};
use crate::config::limits::{FLATTEN_TOLERANCE, LARGEST_MAP};
use crate::plane::{Bounds, SegmentTree, Vec2, WindingTree, wrap_angle};
use crate::{Error, Result};
use core::f64::consts::{FRAC_PI_2, PI};

/// A point of a map's boundary that a whisker may touch from the free side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundarySample {
    /// Index of the boundary.
    pub boundary: usize,
    /// Arc length along the boundary's curve (m), as stored, also on a wall's second side.
    pub arc_length: f64,
    /// The point, map frame (m).
    pub position: Vec2,
    /// Direction of travel with free space on the left, in (-pi, pi] (rad).
    pub tangent: f64,
}

/// The boundary point nearest to a query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapPoint {
    /// Index of the boundary.
    pub boundary: usize,
    /// Arc length along the boundary's curve (m).
    pub arc_length: f64,
    /// The point, map frame (m).
    pub position: Vec2,
    /// Direction of the curve, in (-pi, pi] (rad); free space is on the left, for walls on both sides.
    pub tangent: f64,
    /// Signed curvature of the curve (1/m), positive when it turns left.
    pub curvature: f64,
    /// Distance from the query (m).
    pub distance: f64,
}

/// A corner that a tip can be caught in: free space lies within less than a half turn around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConcaveCorner {
    /// The corner, map frame (m).
    pub position: Vec2,
    /// Normal of the boundary before the corner, towards free space (rad), map frame.
    pub normal_before: f64,
    /// How far the normal turns at the corner, counter-clockwise, in (0, pi) (rad).
    pub turn: f64,
}

/// Where a flattened edge comes from.
#[derive(Clone, Copy, Debug)]
struct Origin {
    boundary: u32,
    segment: u32,
    /// Direction of travel, where the piece is a line (rad).
    tangent: Option<f64>,
}

/// The piece nearest to a place.
#[derive(Clone, Copy, Debug)]
pub struct NearestPiece {
    /// Index of the boundary in [`Map::boundaries`].
    pub boundary: usize,
    /// Index of the piece on it.
    pub segment: usize,
    /// Distance (m).
    pub distance: f64,
    /// The parameter nearest to the place, where the piece is a line.
    pub on_line: Option<f64>,
}

/// What a tip is held against: the boundary's nearest point.
#[derive(Clone, Copy, Debug)]
pub struct Foot {
    /// The point, map frame (m).
    pub position: Vec2,
    /// Direction of the boundary, free space on its left (rad).
    pub tangent: f64,
    /// Whether both sides are free.
    pub two_sided: bool,
}

/// A map of boundaries, in metres, never empty.
///
/// Free space is inside an arena (everywhere when there is none) and outside every obstacle; walls are thin. Look-ups
/// go through chains of lines within a micrometre of the curves ([`FLATTEN_TOLERANCE`]); polylines are exact.
#[derive(Clone, Debug)]
pub struct Map {
    boundaries: Vec<Boundary>,
    tree: SegmentTree,
    origins: Vec<Origin>,
    /// The outlines of arenas, and of obstacles with their holes.
    arenas: WindingTree,
    obstacles: WindingTree,
    corners: Vec<ConcaveCorner>,
    corner_tree: SegmentTree,
    has_arena: bool,
    unknown: UnknownZones,
    /// The largest bound of a band (m), and what any bound leaves open of a direction (rad).
    widest_bound: f64,
    widest_slope: f64,
    /// What looked wrong in the file but could be read, for people.
    pub warnings: Vec<String>,
}

impl Map {
    /// The map made of `boundaries`.
    ///
    /// # Errors
    ///
    /// No boundary at all; more boundaries, pieces or lines than a map may have ([`crate::config::budgets`]).
    pub fn new(boundaries: Vec<Boundary>) -> Result<Self> {
        if boundaries.is_empty() {
            return Err(Error::data("the map is empty").remedy("give it at least one arena, obstacle or wall"));
        }
        let mut cost = MapCost::default();
        boundaries.iter().try_for_each(|boundary| cost.add(boundary.curve().segments()))?;
        let (mut edges, mut origins) = (Vec::new(), Vec::new());
        for (boundary, b) in boundaries.iter().enumerate() {
            for (segment, piece) in b.curve().segments().iter().enumerate() {
                let parts = piece.flat_parts(FLATTEN_TOLERANCE);
                let mut from = piece.start();
                let tangent = (parts == 1 && piece.control_points().len() == 2).then(|| piece.tangent(0.0));
                for k in 1..=parts {
                    let to = if k == parts { piece.end() } else { piece.point(k as f64 / parts as f64) };
                    edges.push([from, to]);
                    origins.push(Origin { boundary: boundary as u32, segment: segment as u32, tangent });
                    from = to;
                }
            }
        }
        let has_arena = boundaries.iter().any(|b| b.role() == Role::Arena);
        let of_role = |role| WindingTree::new(&outlines(&boundaries, &edges, &origins, role));
        let (arenas, obstacles) = (of_role(Role::Arena), of_role(Role::Obstacle));
        let tree = SegmentTree::new(&edges);
        let size = tree.bounds().size();
        let mut warnings = Vec::new();
        if size.x.max(size.y) > LARGEST_MAP {
            warnings.push(format!(
                "the map is {:.0} m by {:.0} m; are its coordinates millimetres where metres are due?",
                size.x, size.y
            ));
        }
        let corners: Vec<_> = boundaries.iter().filter(|b| !b.is_two_sided()).flat_map(concave_corners).collect();
        let corner_points: Vec<_> = corners.iter().map(|c| [c.position; 2]).collect();
        let corner_tree = SegmentTree::new(&corner_points);
        let depth_of =
            |origin: &Origin| match boundaries[origin.boundary as usize].piece_course(origin.segment as usize) {
                Some(PieceCourse::Unknown(depth)) => Some(depth),
                _ => None,
            };
        let zones = edges.iter().zip(&origins).filter_map(|(edge, origin)| Some((*edge, depth_of(origin)?)));
        let unknown = UnknownZones::new(zones.collect());
        let (mut widest_bound, mut widest_slope) = (0.0_f64, 0.0_f64);
        for course in boundaries.iter().filter_map(Boundary::course) {
            for band in course.pieces().iter().filter_map(|piece| piece.widest()) {
                widest_bound = widest_bound.max(band.bound);
                widest_slope = widest_slope.max(course.slope_and_bend(band.bound).0);
            }
        }
        Ok(Self {
            boundaries,
            tree,
            origins,
            arenas,
            obstacles,
            corners,
            corner_tree,
            has_arena,
            unknown,
            widest_bound,
            widest_slope,
            warnings,
        })
    }

    /// The boundaries.
    #[must_use]
    pub fn boundaries(&self) -> &[Boundary] {
        &self.boundaries
    }

    /// How far any place of a known boundary may be from where it is drawn (m); 0 for a map that is exact.
    #[must_use]
    pub fn widest_bound(&self) -> f64 {
        self.widest_bound
    }

    /// How far the direction of any known boundary may be from the drawn one (rad); 0 for a map that is exact.
    #[must_use]
    pub fn widest_slope(&self) -> f64 {
        self.widest_slope
    }

    /// The stretches of which nothing is known.
    #[must_use]
    pub fn unknown(&self) -> &UnknownZones {
        &self.unknown
    }

    /// Whether `point` is in free space: inside an arena when there is any, and outside every obstacle.
    ///
    /// Walls have no inside. A point on a boundary, or within the flattening tolerance of a curved one, may be judged
    /// either way.
    #[must_use]
    pub fn is_free(&self, point: Vec2) -> bool {
        if !point.is_finite() {
            return false;
        }
        // Outlines are travelled with free space on the left: arenas wind +1 and obstacles -1 around what they enclose,
        // and a hole in an obstacle takes its -1 back.
        (!self.has_arena || self.arenas.winding(point) > 0) && self.obstacles.winding(point) >= 0
    }

    /// Whether the closed segment from `a` to `b` meets any boundary; touching counts.
    ///
    /// Decided on the chains of lines: a segment that comes closer than the flattening tolerance to a curved boundary
    /// may be judged either way.
    #[must_use]
    pub fn crosses(&self, a: Vec2, b: Vec2) -> bool {
        self.tree.crosses(a, b)
    }

    /// The boundary point nearest to `point`, on the true curve; its distance is the least up to twice the flattening
    /// tolerance, and exactly the least for polylines.
    ///
    /// None when the query is not finite.
    #[must_use]
    pub fn nearest(&self, point: Vec2) -> Option<MapPoint> {
        self.nearest_within(point, f64::INFINITY)
    }

    /// The boundary point nearest to `point` if it is no further than `reach` (m), as [`Map::nearest`]; faster the
    /// smaller the reach.
    #[must_use]
    pub fn nearest_within(&self, point: Vec2, reach: f64) -> Option<MapPoint> {
        let hit = self.tree.nearest_within(point, reach)?;
        let Origin { boundary, segment, .. } = self.origins[hit.edge];
        let on = self.boundaries[boundary as usize].curve().nearest_near_segment(segment as usize, point);
        Some(MapPoint {
            boundary: boundary as usize,
            arc_length: on.arc_length,
            position: on.position,
            tangent: on.tangent,
            curvature: on.curvature,
            distance: on.position.distance(point),
        })
    }

    /// As [`Map::nearest_within`], without what a tip that looks for its contact does not ask.
    #[must_use]
    pub fn foot(&self, point: Vec2, reach: f64) -> Option<Foot> {
        let hit = self.tree.nearest_within(point, reach)?;
        let Origin { boundary, segment, tangent } = self.origins[hit.edge];
        let boundary = &self.boundaries[boundary as usize];
        let two_sided = boundary.is_two_sided();
        if let Some(tangent) = tangent {
            return Some(Foot { position: hit.point, tangent, two_sided });
        }
        let on = boundary.curve().nearest_near_segment(segment as usize, point);
        Some(Foot { position: on.position, tangent: on.tangent, two_sided })
    }

    /// The piece of a boundary nearest to `point` (m) if it is no further than `reach` (m), within the flattening tolerance.
    #[must_use]
    pub fn nearest_piece(&self, point: Vec2, reach: f64) -> Option<NearestPiece> {
        let hit = self.tree.nearest_within(point, reach)?;
        let Origin { boundary, segment, tangent } = self.origins[hit.edge];
        let on_line = tangent.map(|_| hit.t);
        Some(NearestPiece { boundary: boundary as usize, segment: segment as usize, distance: hit.distance, on_line })
    }

    /// Calls `visit` with the ends of each flattened edge whose rectangle overlaps `bounds`, until it answers true.
    pub fn for_each_edge_in(&self, bounds: Bounds, mut visit: impl FnMut([Vec2; 2]) -> bool) {
        self.tree.for_each_in(bounds, |_, ends| visit(ends));
    }

    /// The concave corner nearest to `point` if it is no further than `reach` (m).
    ///
    /// Corners turn by at least 20 degrees; weaker ones are taken for the polygons of smooth curves. Corners between
    /// walls, or where outlines cross each other, are not found.
    #[must_use]
    pub fn concave_corner(&self, point: Vec2, reach: f64) -> Option<ConcaveCorner> {
        self.corner_tree.nearest_within(point, reach).map(|hit| self.corners[hit.edge])
    }

    /// The rectangle around all boundaries.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        self.tree.bounds()
    }

    /// The length of all boundaries (m); a wall counts once.
    #[must_use]
    pub fn total_length(&self) -> f64 {
        self.boundaries.iter().map(|b| b.curve().length()).sum()
    }

    /// The length of boundary to walk along in `bounds`, in steps of at most `spacing` (m), and how many points
    /// [`Map::samples`] has there, both give or take a piece that leaves the rectangle; a wall counts twice.
    #[must_use]
    pub fn walk_in(&self, bounds: Bounds, spacing: f64) -> (f64, f64) {
        let (mut length, mut points) = (0.0, 0.0);
        // Of a line no more than the rectangle's diagonal is in there.
        let most = bounds.size().norm();
        for boundary in &self.boundaries {
            let sides = if boundary.is_two_sided() { 2.0 } else { 1.0 };
            for segment in boundary.curve().segments().iter().filter(|s| s.bounds().overlaps(bounds)) {
                let line = segment.control_points().len() == 2;
                let own = if line { segment.length().min(most) } else { segment.length() };
                length += sides * own;
                points += sides * (own / spacing).ceil().max(1.0);
            }
        }
        (length, points)
    }

    /// Points along all boundaries, each with free space on the left, at most `spacing` (m) apart within each piece.
    ///
    /// Walls give every point twice, once for each side. See [`crate::plane::Curve::samples`].
    #[must_use]
    pub fn samples(&self, spacing: f64) -> Vec<BoundarySample> {
        let everywhere = Vec2::new(f64::INFINITY, f64::INFINITY);
        self.samples_in(Bounds { min: -everywhere, max: everywhere }, spacing)
    }

    /// Those of [`Map::samples`] that lie in `bounds`.
    #[must_use]
    pub fn samples_in(&self, bounds: Bounds, spacing: f64) -> Vec<BoundarySample> {
        let mut samples = Vec::new();
        for (boundary, b) in self.boundaries.iter().enumerate() {
            let mut points = b.curve().samples_of(spacing, |segment| segment.bounds().overlaps(bounds));
            points.retain(|point| bounds.contains(point.position));
            let sample = |arc_length, position, tangent| BoundarySample { boundary, arc_length, position, tangent };
            samples.extend(points.iter().map(|p| sample(p.arc_length, p.position, p.tangent)));
            if b.is_two_sided() {
                let back = points.iter().rev();
                samples.extend(back.map(|p| sample(p.arc_length, p.position, wrap_angle(p.tangent + PI))));
            }
        }
        samples
    }
}

/// The flattened outlines of the boundaries of a role, the first corner repeated at the end.
fn outlines(boundaries: &[Boundary], edges: &[[Vec2; 2]], origins: &[Origin], role: Role) -> Vec<Vec<Vec2>> {
    let mut chains: Vec<Vec<Vec2>> = Vec::new();
    let mut last = None;
    for (edge, origin) in edges.iter().zip(origins) {
        if boundaries[origin.boundary as usize].role() != role {
            continue;
        }
        if last.replace(origin.boundary) != Some(origin.boundary) {
            chains.push(Vec::new());
        }
        chains.last_mut().into_iter().for_each(|chain| chain.push(edge[0]));
    }
    chains.iter_mut().for_each(|chain| chain.extend(chain.first().copied()));
    chains
}

/// Least turn of a corner that is meant as one (rad): 20 degrees.
const LEAST_CORNER: f64 = 0.35;

/// The corners of an outline at which it turns towards free space, which lies on its left.
fn concave_corners(boundary: &Boundary) -> Vec<ConcaveCorner> {
    let segments = boundary.curve().segments();
    let mut corners = Vec::new();
    for (index, segment) in segments.iter().enumerate() {
        let before = &segments[(index + segments.len() - 1) % segments.len()];
        let turn = wrap_angle(segment.tangent(0.0) - before.tangent(1.0));
        if (LEAST_CORNER..PI).contains(&turn) {
            let normal_before = before.tangent(1.0) + FRAC_PI_2;
            corners.push(ConcaveCorner { position: segment.start(), normal_before, turn });
        }
    }
    corners
}
