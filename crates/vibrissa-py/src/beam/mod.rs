//! Loaded whiskers: arrays of problems in, arrays of equilibria out.

mod problems;
mod rows;

use crate::arrays::{Column, Table, block, points, table};
use crate::error::{OrRaise, exception};
use crate::inputs::WhiskerIn;
use crate::long::{Watch, run};
use numpy::{PyArray1, PyArray3, PyReadonlyArray1};
use problems::{Given, Problems};
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::PyIterator;
use rows::{Row, Rows};
use std::sync::Arc;
use vibrissa::beam::{ShapePoint, Whisker};
use vibrissa::figure::numbers::{fixed, significant};
use vibrissa::tasks::batch;
use vibrissa::{Error, Result};

/// Problems that are solved on the spot; more of them get a thread of their own, so that Ctrl-C works.
const AT_ONCE: usize = 64;

/// Equilibria of loaded whiskers, one row each: every branch of every problem, in order.
///
/// All columns have shape (rows). Whisker frame: base at the origin, undeflected along +x, a push towards +y positive.
#[pyclass(frozen, module = "vibrissa", sequence)]
#[derive(Debug, Default)]
pub(crate) struct Bends {
    problems: usize,
    rows: Rows,
    faults: Vec<(usize, Error)>,
    whiskers: Vec<Whisker>,
}

impl Bends {
    fn whisker(&self, row: &Row) -> &Whisker {
        &self.whiskers[if self.whiskers.len() == 1 { 0 } else { row.case }]
    }

    fn shape_numbers<const N: usize>(&self, n: usize, of: impl Fn(f64, ShapePoint) -> [f64; N]) -> Vec<f64> {
        let shape = |row: &Row| row.bend.shape_points(self.whisker(row).length, n);
        self.rows.iter().flat_map(shape).flat_map(|(s, point)| of(s, point)).collect()
    }
}

#[pymethods]
impl Bends {
    /// Which problem each row solves, from 0 on in the order of the (flattened) inputs; int64.
    #[getter]
    fn case<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i64>>> {
        self.rows.column(py, |row| row.case as i64)
    }

    /// Which solution of its problem each row is, least slope first; int64.
    #[getter]
    fn branch<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i64>>> {
        self.rows.column(py, |row| row.branch as i64)
    }

    /// Force along the load's direction (N).
    #[getter]
    fn force<'py>(&self, py: Python<'py>) -> PyResult<Column<'py>> {
        self.rows.column(py, |row| row.bend.force)
    }

    /// Arc length from the base to the contact (m).
    #[getter]
    fn s_a<'py>(&self, py: Python<'py>) -> PyResult<Column<'py>> {
        self.rows.column(py, |row| row.bend.s_a)
    }

    /// Slope at the contact (rad).
    #[getter]
    fn phi_a<'py>(&self, py: Python<'py>) -> PyResult<Column<'py>> {
        self.rows.column(py, |row| row.bend.phi_a)
    }

    /// Rotation from the whisker's normal at the contact to the load (rad).
    #[getter]
    fn beta<'py>(&self, py: Python<'py>) -> PyResult<Column<'py>> {
        self.rows.column(py, |row| row.bend.beta)
    }

    /// The contact along the undeflected whisker (m).
    #[getter]
    fn x<'py>(&self, py: Python<'py>) -> PyResult<Column<'py>> {
        self.rows.column(py, |row| row.bend.contact.x)
    }

    /// The contact across the undeflected whisker (m).
    #[getter]
    fn y<'py>(&self, py: Python<'py>) -> PyResult<Column<'py>> {
        self.rows.column(py, |row| row.bend.contact.y)
    }

    /// Moment about the base (N m).
    #[getter]
    fn moment<'py>(&self, py: Python<'py>) -> PyResult<Column<'py>> {
        self.rows.column(py, |row| row.bend.moment)
    }

    /// Elastic energy (J).
    #[getter]
    fn energy<'py>(&self, py: Python<'py>) -> PyResult<Column<'py>> {
        self.rows.column(py, |row| row.bend.energy())
    }

    /// How far the base has turned (rad); 0 when it is clamped.
    #[getter]
    fn base_angle<'py>(&self, py: Python<'py>) -> PyResult<Column<'py>> {
        self.rows.column(py, |row| row.bend.base_angle())
    }

    /// The force as vectors (N), shape (rows, 2).
    #[getter]
    fn force_vector<'py>(&self, py: Python<'py>) -> PyResult<Table<'py>> {
        table(py, self.rows.iter(), |row| [row.bend.force_vector().x, row.bend.force_vector().y])
    }

    /// The tips (m), shape (rows, 2).
    #[getter]
    fn tip<'py>(&self, py: Python<'py>) -> PyResult<Table<'py>> {
        let tip = |row: &Row| row.bend.tip(self.whisker(row).length);
        table(py, self.rows.iter().map(tip), |tip| [tip.x, tip.y])
    }

    /// How many problems there were, with and without a solution.
    #[getter]
    fn problems(&self) -> usize {
        self.problems
    }

    /// The problems that made no sense, with their errors' texts; filled with errors="skip".
    #[getter]
    fn faults(&self) -> Vec<(usize, String)> {
        self.faults.iter().map(|(case, error)| (*case, error.to_string())).collect()
    }

    /// Points from base to tip, evenly spaced in arc length (m); shape (rows, n, 2).
    #[pyo3(signature = (n=101))]
    fn shape<'py>(&self, py: Python<'py>, n: usize) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let n = if n < 2 { 0 } else { n };
        let flat = py.detach(|| self.shape_numbers(n, |_, p| [p.position.x, p.position.y]));
        block(py, flat, [self.rows.len(), n, 2])
    }

    /// As `shape` with arc length, place, slope and curvature (m, m, m, rad, 1/m); shape (rows, n, 5).
    #[pyo3(signature = (n=101))]
    fn shape_points<'py>(&self, py: Python<'py>, n: usize) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let n = if n < 2 { 0 } else { n };
        let flat = py.detach(|| self.shape_numbers(n, |s, p| [s, p.position.x, p.position.y, p.slope, p.curvature]));
        block(py, flat, [self.rows.len(), n, 5])
    }

    /// Where the surface is strained the most: arc length (m), curvature (1/m), strain; shape (rows, 3), NaN without a
    /// diameter.
    fn largest_strain<'py>(&self, py: Python<'py>) -> PyResult<Table<'py>> {
        let one = |row: &Row| match row.bend.largest_strain_of(self.whisker(row)) {
            Some(most) => [most.s, most.curvature, most.strain],
            None => [f64::NAN; 3],
        };
        let found: Vec<[f64; 3]> = py.detach(|| self.rows.iter().map(one).collect());
        table(py, found, |row| row)
    }

    fn __len__(&self) -> usize {
        self.rows.len()
    }

    fn __getitem__(&self, index: isize) -> PyResult<Bend> {
        let at = if index < 0 { index + self.rows.len() as isize } else { index };
        let row = usize::try_from(at).ok().and_then(|at| self.rows.get(at));
        let row = row.ok_or_else(|| PyIndexError::new_err("no such equilibrium"))?;
        Ok(Bend { row: row.clone(), whisker: *self.whisker(row) })
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyIterator>> {
        let one = |row: &Row| Bend { row: row.clone(), whisker: *self.whisker(row) };
        self.rows.iter().map(one).collect::<Vec<_>>().into_pyobject(py)?.try_iter()
    }

    fn __repr__(&self) -> String {
        let (rows, problems) = (self.rows.len(), self.problems);
        let nouns = (if rows == 1 { "equilibrium" } else { "equilibria" }, if problems == 1 { "" } else { "s" });
        format!("<vibrissa.Bends: {rows} {} of {problems} problem{}>", nouns.0, nouns.1)
    }
}

/// One loaded whisker in equilibrium; units and frame as in `Bends`.
#[pyclass(frozen, module = "vibrissa")]
#[derive(Debug)]
pub(crate) struct Bend {
    row: Row,
    whisker: Whisker,
}

#[pymethods]
impl Bend {
    /// Which problem it solves.
    #[getter]
    fn case(&self) -> usize {
        self.row.case
    }

    /// Which solution of its problem it is, least slope first.
    #[getter]
    fn branch(&self) -> usize {
        self.row.branch
    }

    /// Force along the load's direction (N).
    #[getter]
    fn force(&self) -> f64 {
        self.row.bend.force
    }

    /// Arc length from the base to the contact (m).
    #[getter]
    fn s_a(&self) -> f64 {
        self.row.bend.s_a
    }

    /// Slope at the contact (rad).
    #[getter]
    fn phi_a(&self) -> f64 {
        self.row.bend.phi_a
    }

    /// Rotation from the whisker's normal at the contact to the load (rad).
    #[getter]
    fn beta(&self) -> f64 {
        self.row.bend.beta
    }

    /// The contact along the undeflected whisker (m).
    #[getter]
    fn x(&self) -> f64 {
        self.row.bend.contact.x
    }

    /// The contact across the undeflected whisker (m).
    #[getter]
    fn y(&self) -> f64 {
        self.row.bend.contact.y
    }

    /// Moment about the base (N m).
    #[getter]
    fn moment(&self) -> f64 {
        self.row.bend.moment
    }

    /// Elastic energy (J).
    #[getter]
    fn energy(&self) -> f64 {
        self.row.bend.energy()
    }

    /// The tip (m).
    #[getter]
    fn tip(&self) -> (f64, f64) {
        let tip = self.row.bend.tip(self.whisker.length);
        (tip.x, tip.y)
    }

    /// Points from base to tip, evenly spaced in arc length (m); shape (n, 2).
    #[pyo3(signature = (n=101))]
    fn shape<'py>(&self, py: Python<'py>, n: usize) -> PyResult<Table<'py>> {
        points(py, &self.row.bend.shape(self.whisker.length, n))
    }

    fn __repr__(&self) -> String {
        let bend = &self.row.bend;
        format!(
            "<vibrissa.Bend: F {} N at s_a {:.3} mm, phi_a {} deg, contact ({}, {}) mm, M(0) {} mN m>",
            significant(bend.force, 4),
            bend.s_a * 1e3,
            fixed(bend.phi_a.to_degrees(), 3),
            fixed(bend.contact.x * 1e3, 3),
            fixed(bend.contact.y * 1e3, 3),
            significant(bend.moment * 1e3, 4)
        )
    }
}

/// Solves `count` problems; each column holds one number for all of them, or one for each; see `vibrissa._beam`.
#[pyfunction]
#[allow(clippy::too_many_arguments)] // Called from one place, by name.
pub(crate) fn bends(
    py: Python<'_>,
    given: &str,
    count: usize,
    first: PyReadonlyArray1<'_, f64>,
    second: PyReadonlyArray1<'_, f64>,
    load: &str,
    angles: Option<PyReadonlyArray1<'_, f64>>,
    whiskers: Vec<WhiskerIn>,
    skip_faults: bool,
    threads: Option<usize>,
) -> PyResult<Bends> {
    let given = match given {
        "force" => Given::Force,
        "moment" => Given::Moment,
        "point" => Given::Point,
        _ => Given::Tip,
    };
    let numbers = |column: &PyReadonlyArray1<'_, f64>| column.as_slice().map(<[f64]>::to_vec);
    let angles = angles.as_ref().map(numbers).transpose()?.unwrap_or_default();
    let whiskers = whiskers.iter().map(WhiskerIn::whisker).collect::<Result<Vec<_>>>().or_raise(py)?;
    if count == 0 {
        return Ok(Bends { whiskers, ..Bends::default() });
    }
    let columns = [numbers(&first)?, numbers(&second)?, angles];
    // What every problem shares is at fault even where faults are skipped.
    let problems = Problems::new(given, count, columns, load, whiskers).or_raise(py)?;
    let threads = threads.unwrap_or_else(batch::all_cores).max(1);
    let solved = if problems.count() <= AT_ONCE {
        let watch = Arc::new(Watch::default());
        py.detach(|| problems.solve_all(1, &watch))
    } else {
        run(py, None, 0, move |watch| Ok(problems.solve_all(threads, watch)))?
    };
    match solved.faults.first() {
        Some((case, error)) if !skip_faults => {
            let text = if solved.problems > 1 { format!("problem {case}: {error}") } else { error.to_string() };
            Err(exception(py, error, text))
        }
        _ => Ok(solved),
    }
}
