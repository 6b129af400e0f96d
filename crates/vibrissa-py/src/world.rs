//! Maps.

use crate::arrays::{Like2, Table, column, points, rows, table};
use crate::error::{OrRaise, warn};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::Arc;
use vibrissa::config::limits::FLATTEN_TOLERANCE;
use vibrissa::figure::map_figure;
use vibrissa::io::text::counted;
use vibrissa::plane::{Curve, Segment, Vec2};
use vibrissa::tasks::{demo, outlines};
use vibrissa::world::{Band, Boundary, Course, PieceCourse, Role};
use vibrissa::{Error, Result};

/// A map of the plane: arena, obstacles and walls (m), x right and y up as drawn.
#[pyclass(frozen, module = "vibrissa", name = "Map")]
#[derive(Debug)]
pub(crate) struct PyMap(pub(crate) Arc<vibrissa::world::Map>);

impl PyMap {
    fn new(py: Python<'_>, map: vibrissa::world::Map) -> PyResult<Self> {
        warn(py, &map.warnings)?;
        Ok(Self(Arc::new(map)))
    }
}

#[pymethods]
impl PyMap {
    /// The map of a file: .geojson (m), .svg (mm), .dxf, .yaml or .mcap.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let map = py.detach(|| vibrissa::read_map(path)).or_raise(py)?;
        Self::new(py, map)
    }

    /// The map of a GeoJSON text (m); `name` stands for the file in messages.
    #[staticmethod]
    #[pyo3(signature = (text, name="map.geojson"))]
    fn from_geojson(py: Python<'_>, text: &str, name: &str) -> PyResult<Self> {
        let map = vibrissa::io::map::from_geojson(text, name).or_raise(py)?;
        Self::new(py, map)
    }

    /// The map of an SVG text (mm unless it says otherwise); `name` stands for the file in messages.
    #[staticmethod]
    #[pyo3(signature = (text, name="map.svg"))]
    fn from_svg(py: Python<'_>, text: &str, name: &str) -> PyResult<Self> {
        let map = vibrissa::io::map::from_svg(text, name).or_raise(py)?;
        Self::new(py, map)
    }

    /// The map of a DXF text (layers say the roles); `name` stands for the file in messages.
    #[staticmethod]
    #[pyo3(signature = (text, name="map.dxf"))]
    fn from_dxf(py: Python<'_>, text: &str, name: &str) -> PyResult<Self> {
        let map = vibrissa::io::map::from_dxf(text, name).or_raise(py)?;
        Self::new(py, map)
    }

    /// The built-in arena of the demo.
    #[staticmethod]
    fn demo(py: Python<'_>) -> PyResult<Self> {
        let map = demo::arena().or_raise(py)?;
        Self::new(py, map)
    }

    /// The map of corner points (m): lists of arrays of shape (n, 2).
    ///
    /// Free space is inside the arenas and outside the obstacles; a wall is thin and solid on both sides.
    #[staticmethod]
    #[pyo3(signature = (arenas=None, obstacles=None, walls=None))]
    fn from_points(
        py: Python<'_>,
        arenas: Option<Vec<Like2<'_>>>,
        obstacles: Option<Vec<Like2<'_>>>,
        walls: Option<Vec<Like2<'_>>>,
    ) -> PyResult<Self> {
        let mut boundaries = Vec::new();
        for (role, lines) in [(Role::Arena, arenas), (Role::Obstacle, obstacles), (Role::Wall, walls)] {
            for line in lines.unwrap_or_default() {
                boundaries.push(boundary(role, &rows(&line)?).or_raise(py)?);
            }
        }
        let map = vibrissa::world::Map::new(boundaries).or_raise(py)?;
        Self::new(py, map)
    }

    /// What looked wrong but could be read, for people.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.0.warnings.clone()
    }

    /// Least and largest x, least and largest y (m).
    #[getter]
    fn bounds(&self) -> (f64, f64, f64, f64) {
        let bounds = self.0.bounds();
        (bounds.min.x, bounds.max.x, bounds.min.y, bounds.max.y)
    }

    /// Length of all boundaries together (m).
    #[getter]
    fn total_length(&self) -> f64 {
        self.0.total_length()
    }

    /// The boundaries as polylines within `tolerance` (m) of their curves: a list of role ("arena", "obstacle" or "wall")
    /// and points of shape (n, 2); a closed line repeats its first point.
    #[pyo3(signature = (tolerance=None))]
    fn boundaries<'py>(&self, py: Python<'py>, tolerance: Option<f64>) -> PyResult<Vec<(&'static str, Table<'py>)>> {
        let tolerance = tolerance.unwrap_or(FLATTEN_TOLERANCE);
        if !(tolerance >= 1e-9 && tolerance.is_finite()) {
            return Err(Error::usage("tolerance").value(tolerance).allowed("1e-9 m or more")).or_raise(py);
        }
        let line = |boundary: &Boundary| {
            let mut chain = boundary.curve().flatten(tolerance);
            let open = chain.len() > 1 && boundary.curve().is_closed();
            if let (true, Some(&first)) = (open, chain.first()) {
                chain.pop();
                chain.push(first);
            }
            Ok((boundary.role().word(), points(py, &chain)?))
        };
        self.0.boundaries().iter().map(line).collect()
    }

    /// Whether each point of shape (n, 2) (m) lies in free space; shape (n).
    fn is_free<'py>(&self, py: Python<'py>, points: Like2<'_>) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let (map, points) = (&self.0, rows(&points)?);
        let free: Vec<bool> = py.detach(|| points.iter().map(|&[x, y]| map.is_free(Vec2::new(x, y))).collect());
        Ok(PyArray1::from_vec(py, free))
    }

    /// The boundary point nearest to each point of shape (n, 2) (m): "point" (n, 2) (m), "distance" (n) (m), "tangent" (n)
    /// (rad), free space on its left, and "curvature" (n) (1/m).
    fn nearest<'py>(&self, py: Python<'py>, points: Like2<'_>) -> PyResult<Bound<'py, PyDict>> {
        let (map, points) = (&self.0, rows(&points)?);
        let found: Vec<_> = py.detach(|| points.iter().filter_map(|&[x, y]| map.nearest(Vec2::new(x, y))).collect());
        let out = PyDict::new(py);
        out.set_item("point", table(py, &found, |p| [p.position.x, p.position.y])?)?;
        out.set_item("distance", column(py, &found, |p| p.distance))?;
        out.set_item("tangent", column(py, &found, |p| p.tangent))?;
        out.set_item("curvature", column(py, &found, |p| p.curvature))?;
        Ok(out)
    }

    /// How exactly the boundaries are known: quadrilaterals of shape (4, 2) (m) that the true ones lie in, and lines of shape (n, 2)
    /// (m) along stretches of which nothing is known; none of an exact map.
    fn bands<'py>(&self, py: Python<'py>) -> PyResult<(Vec<Table<'py>>, Vec<Table<'py>>)> {
        let drawn = outlines(&self.0, FLATTEN_TOLERANCE);
        let bands = drawn.iter().flat_map(|outline| &outline.band).map(|corners| points(py, corners));
        let unknown = drawn.iter().flat_map(|outline| &outline.unknown).map(|line| points(py, line));
        Ok((bands.collect::<PyResult<_>>()?, unknown.collect::<PyResult<_>>()?))
    }

    /// The map as a GeoJSON text (m), which `from_geojson` reads; curves become lines.
    fn to_geojson(&self) -> String {
        vibrissa::io::map::to_geojson(&self.0)
    }

    /// Draws the boundaries into axes of matplotlib (m), new ones for None, and gives them.
    #[pyo3(signature = (ax=None))]
    fn plot<'py>(slf: &Bound<'py, Self>, ax: Option<Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyAny>> {
        let module = slf.py().import("vibrissa._show")?;
        let axes = module.getattr("axes")?.call1((ax,))?;
        module.getattr("draw_map")?.call1((&axes, slf))?;
        Ok(axes)
    }

    /// The map as a figure, as notebooks show it.
    fn _repr_svg_(&self) -> String {
        let captions = [self.size()];
        map_figure("A map", &captions, "map frame", &outlines(&self.0, FLATTEN_TOLERANCE), &[])
    }

    /// What the map is made of, for copies in other processes: role, whether it is closed, whether it is the hole of an
    /// obstacle, the control points of its pieces, how exactly these are known, and its name.
    fn _parts(&self) -> Vec<Parts> {
        let piece = |segment: &Segment| segment.control_points().iter().map(|p| (p.x, p.y)).collect();
        let parts = |boundary: &Boundary| {
            let curve = boundary.curve();
            let hole = boundary.role() == Role::Obstacle && curve.signed_area() > 0.0;
            let pieces = curve.segments().iter().map(piece).collect();
            (
                boundary.role().word(),
                curve.is_closed(),
                hole,
                pieces,
                boundary.course().map(course_numbers),
                boundary.name().map(str::to_owned),
            )
        };
        self.0.boundaries().iter().map(parts).collect()
    }

    /// The map of `_parts`.
    #[staticmethod]
    fn _from_parts(py: Python<'_>, parts: Vec<OwnParts>, warnings: Vec<String>) -> PyResult<Self> {
        let made = |(role, closed, hole, pieces, course, name): OwnParts| {
            let fault = || Error::data("a map that was not written by this version");
            let role = Role::from_word(&role).ok_or_else(fault)?;
            let segments = pieces.iter().map(|points| segment(points)).collect::<Option<Vec<Segment>>>();
            let curve = segments.and_then(|s| Curve::from_segments(s, closed)).ok_or_else(fault)?;
            let boundary = Boundary::checked(role, curve, hole, name).map_err(|fault| fault.error)?;
            match course {
                Some(numbers) => boundary.with_course(course_of(&numbers)?),
                None => Ok(boundary),
            }
        };
        let boundaries = parts.into_iter().map(made).collect::<Result<Vec<Boundary>>>().or_raise(py)?;
        let mut map = vibrissa::world::Map::new(boundaries).or_raise(py)?;
        map.warnings = warnings;
        Ok(Self(Arc::new(map)))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Pickled)> {
        let make = py.get_type::<Self>().getattr("_from_parts")?;
        Ok((make, (self._parts(), self.0.warnings.clone())))
    }

    fn __repr__(&self) -> String {
        format!("<vibrissa.Map: {}>", self.size())
    }
}

impl PyMap {
    /// How many boundaries there are, and how large all is.
    fn size(&self) -> String {
        let size = self.0.bounds().max - self.0.bounds().min;
        let boundaries = counted(self.0.boundaries().len(), "boundary", "boundaries");
        format!("{boundaries}, {:.3} m by {:.3} m", size.x, size.y)
    }
}

/// Pieces of a curve by their control points (m).
type Pieces = Vec<Vec<(f64, f64)>>;
/// How exactly a boundary is known: for each piece its depth, or standard deviation and bound at both of its ends, and the
/// correlation length (m).
type CourseNumbers = (Vec<Vec<f64>>, f64);
/// A boundary: role, closed, hole, pieces, how exactly they are known, its name.
type Parts = (&'static str, bool, bool, Pieces, Option<CourseNumbers>, Option<String>);
/// The same, read.
type OwnParts = (String, bool, bool, Pieces, Option<CourseNumbers>, Option<String>);

/// What a pickled map is made of: its boundaries and its warnings.
type Pickled = (Vec<Parts>, Vec<String>);

fn course_numbers(course: &Course) -> CourseNumbers {
    let numbers = |piece: &PieceCourse| match *piece {
        PieceCourse::Unknown(depth) => vec![depth],
        PieceCourse::Band([from, to]) => vec![from.std, from.bound, to.std, to.bound],
    };
    (course.pieces().iter().map(numbers).collect(), course.correlation_length())
}

fn course_of((pieces, correlation_length): &CourseNumbers) -> Result<Course> {
    let piece = |numbers: &Vec<f64>| match numbers[..] {
        [depth] => Ok(PieceCourse::Unknown(depth)),
        [std, bound, far_std, far_bound] => {
            Ok(PieceCourse::Band([Band { std, bound }, Band { std: far_std, bound: far_bound }]))
        }
        _ => Err(Error::data("a map that was not written by this version")),
    };
    Course::new(pieces.iter().map(piece).collect::<Result<_>>()?, *correlation_length)
}

fn segment(points: &[(f64, f64)]) -> Option<Segment> {
    let at = |k: usize| Vec2::new(points[k].0, points[k].1);
    match points.len() {
        2 => Some(Segment::Line([at(0), at(1)])),
        3 => Some(Segment::Quadratic([at(0), at(1), at(2)])),
        4 => Some(Segment::Cubic([at(0), at(1), at(2), at(3)])),
        _ => None,
    }
}

fn boundary(role: Role, corners: &[[f64; 2]]) -> Result<Boundary> {
    let mut corners: Vec<Vec2> = corners.iter().map(|&[x, y]| Vec2::new(x, y)).collect();
    let closed = role != Role::Wall;
    if closed && corners.len() > 1 && corners.first() == corners.last() {
        corners.pop();
    }
    let curve = Curve::polyline(&corners, closed).ok_or_else(|| {
        Error::usage(format!("the corners of {} {}", if role == Role::Wall { "a" } else { "an" }, role.word()))
            .value(format!("{} points", corners.len()))
            .allowed("different finite points, at least 3 of a polygon and 2 of a wall (m)")
    })?;
    Boundary::new(role, curve, None)
}
