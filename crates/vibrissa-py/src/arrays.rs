//! Our numbers as NumPy arrays.

use crate::error::OrRaise;
use numpy::{
    AllowTypeChange, PyArray1, PyArray2, PyArray3, PyArrayLike1, PyArrayLike2, PyArrayMethods, PyReadonlyArray1,
    PyReadonlyArray2, PyUntypedArrayMethods,
};
use pyo3::prelude::*;
use vibrissa::flow::pose::{Event, StampedPose};
use vibrissa::plane::{Pose2, Vec2};

pub(crate) type Column<'py> = Bound<'py, PyArray1<f64>>;
pub(crate) type Table<'py> = Bound<'py, PyArray2<f64>>;

/// What NumPy makes an array of shape (n) of: lists, arrays of other types and strides.
pub(crate) type Like1<'py> = PyArrayLike1<'py, f64, AllowTypeChange>;
/// The same of shape (n, m).
pub(crate) type Like2<'py> = PyArrayLike2<'py, f64, AllowTypeChange>;

/// The numbers of an array of shape (n), whatever its strides.
pub(crate) fn numbers(array: &PyReadonlyArray1<'_, f64>) -> Vec<f64> {
    array.as_array().iter().copied().collect()
}

/// The rows of an array of shape (n, N), whatever its strides.
pub(crate) fn rows<const N: usize>(array: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<[f64; N]>> {
    let (view, columns) = (array.as_array(), array.shape()[1]);
    if columns != N {
        let error = vibrissa::Error::usage("the number of columns").value(columns).allowed(N.to_string());
        return Err(error).or_raise(array.py());
    }
    Ok(view.rows().into_iter().map(|row| core::array::from_fn(|i| row[i])).collect())
}

/// One number for each item.
pub(crate) fn column<'py, T>(py: Python<'py>, items: &[T], value: impl Fn(&T) -> f64) -> Column<'py> {
    PyArray1::from_iter(py, items.iter().map(value))
}

/// One whole number for each item.
pub(crate) fn counts<'py, T>(py: Python<'py>, items: &[T], value: impl Fn(&T) -> usize) -> Bound<'py, PyArray1<i64>> {
    PyArray1::from_iter(py, items.iter().map(|item| value(item) as i64))
}

/// One row of `N` numbers for each item: shape (items, N).
pub(crate) fn table<T, const N: usize>(
    py: Python<'_>,
    items: impl IntoIterator<Item = T>,
    row: impl Fn(T) -> [f64; N],
) -> PyResult<Table<'_>> {
    let flat: Vec<f64> = items.into_iter().flat_map(row).collect();
    let rows = flat.len() / N;
    PyArray1::from_vec(py, flat).reshape([rows, N])
}

/// `(x, y)` of each point: shape (points, 2).
pub(crate) fn points<'py>(py: Python<'py>, points: &[Vec2]) -> PyResult<Table<'py>> {
    table(py, points, |p| [p.x, p.y])
}

/// `(x, y, theta)` of each pose: shape (poses, 3).
pub(crate) fn poses(py: Python<'_>, poses: impl IntoIterator<Item = Pose2>) -> PyResult<Table<'_>> {
    table(py, poses, |p| [p.x, p.y, p.theta])
}

/// Numbers laid out as (a, b, c).
pub(crate) fn block(py: Python<'_>, flat: Vec<f64>, shape: [usize; 3]) -> PyResult<Bound<'_, PyArray3<f64>>> {
    PyArray1::from_vec(py, flat).reshape(shape)
}

/// Stamps and poses of a trajectory: `t` of shape (n), poses of shape (n, 3).
pub(crate) fn trajectory<'py>(py: Python<'py>, rows: &[StampedPose]) -> PyResult<(Column<'py>, Table<'py>)> {
    Ok((column(py, rows, |row| row.t), poses(py, rows.iter().map(|row| row.map_from_robot))?))
}

/// Events as tuples of time, kind and detail.
pub(crate) fn events(events: &[Event]) -> Vec<(f64, &'static str, String)> {
    events.iter().map(|event| (event.t, event.kind, event.detail.clone())).collect()
}

/// A trajectory from its stamps and poses; the shapes have been checked.
pub(crate) fn stamped(t: &[f64], poses: &[[f64; 3]]) -> Vec<StampedPose> {
    let one = |(&t, &[x, y, theta]): (&f64, &[f64; 3])| StampedPose { t, map_from_robot: Pose2::new(x, y, theta) };
    t.iter().zip(poses).map(one).collect()
}
