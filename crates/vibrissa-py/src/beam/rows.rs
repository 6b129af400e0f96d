//! Equilibria in the order of their problems, kept in the parts in which threads solved them.

use numpy::{Element, PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use std::thread;
use vibrissa::beam::Bend;

/// Fewest rows for which a second thread is worth its start.
const WORTH_A_THREAD: usize = 20_000;

#[derive(Clone, Debug)]
pub(super) struct Row {
    pub(super) case: usize,
    pub(super) branch: usize,
    pub(super) bend: Bend,
}

/// Rows that are never moved once they are solved: a million of them are 128 MB.
#[derive(Debug, Default)]
pub(super) struct Rows {
    parts: Vec<Vec<Row>>,
    /// The number of rows before each part.
    starts: Vec<usize>,
    len: usize,
    threads: usize,
}

impl Rows {
    pub(super) fn new(parts: Vec<Vec<Row>>, threads: usize) -> Self {
        let mut len = 0;
        let starts = parts.iter().map(|part| (len, len += part.len()).0).collect();
        Self { parts, starts, len, threads }
    }

    pub(super) fn len(&self) -> usize {
        self.len
    }

    pub(super) fn get(&self, at: usize) -> Option<&Row> {
        let part = self.starts.partition_point(|&start| start <= at).checked_sub(1)?;
        self.parts[part].get(at - self.starts[part])
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &Row> {
        self.parts.iter().flatten()
    }

    /// One number for each row, written where NumPy keeps it.
    pub(super) fn column<'py, R: Element + Copy + Send>(
        &self,
        py: Python<'py>,
        value: impl Fn(&Row) -> R + Send + Sync,
    ) -> PyResult<Bound<'py, PyArray1<R>>> {
        let array = PyArray1::zeros(py, self.len, false);
        let mut ours = array.readwrite();
        let out = ours.as_slice_mut()?;
        py.detach(|| self.fill(out, value));
        drop(ours);
        Ok(array)
    }

    /// Writes the value of each row to `out`, which is as long.
    fn fill<R: Send>(&self, out: &mut [R], value: impl Fn(&Row) -> R + Sync) {
        let mut rest = out;
        let mut jobs = Vec::with_capacity(self.parts.len());
        for part in &self.parts {
            let (now, later) = rest.split_at_mut(part.len());
            jobs.push((part, now));
            rest = later;
        }
        let write = |jobs: &mut [(&Vec<Row>, &mut [R])]| {
            for (part, slots) in jobs {
                slots.iter_mut().zip(part.iter()).for_each(|(slot, row)| *slot = value(row));
            }
        };
        let workers = self.threads.min(self.len / WORTH_A_THREAD);
        if workers < 2 {
            write(&mut jobs);
            return;
        }
        let share = jobs.len().div_ceil(workers);
        thread::scope(|scope| {
            for some in jobs.chunks_mut(share) {
                scope.spawn(|| write(some));
            }
        });
    }
}
