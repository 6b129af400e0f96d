//! Union of contractors \[chabert2009contractor\]: what a reading leaves of a cell, over all contacts that explain it.

use super::parallelotope::LinearForm;

/// A part of a cell: the range along each of its sides.
pub(super) type SubBox = [(f64, f64); 3];

/// What is left of a cell.
pub(super) struct Contraction {
    pub(super) part: SubBox,
    /// A strip that holds all that is left.
    pub(super) form: LinearForm,
    pub(super) range: (f64, f64),
    /// Whether that is all of the cell, whatever else explains the reading.
    pub(super) is_whole: bool,
}

pub(super) const WHOLE: SubBox = [(-1.0, 1.0); 3];

impl Contraction {
    /// The union with another strip and part.
    pub(super) fn join(left: &mut Option<Self>, part: SubBox, form: LinearForm, (lo, hi): (f64, f64)) {
        let all = left.get_or_insert(Self { part, form, range: (lo, hi), is_whole: false });
        for (a, b) in all.part.iter_mut().zip(part) {
            *a = (a.0.min(b.0), a.1.max(b.1));
        }
        let off = all.form.iter().zip(form).map(|(a, b)| (a - b).abs()).sum::<f64>();
        all.range = (all.range.0.min(lo - off), all.range.1.max(hi + off));
        if all.part == WHOLE {
            let most = all.form.iter().map(|k| k.abs()).sum::<f64>();
            all.is_whole = all.range.0 <= -most && all.range.1 >= most;
        }
    }
}

/// Whether all of the cell is left.
pub(super) fn is_whole(left: &Option<Contraction>) -> bool {
    left.as_ref().is_some_and(|left| left.is_whole)
}
