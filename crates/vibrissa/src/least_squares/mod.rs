//! Least squares, once: Levenberg and Marquardt's method for many unknowns that know only their neighbours and for few
//! that know all, linear fits, covariances.
//!
//! | door | for |
//! | --- | --- |
//! | [`descend`] | a problem that brings its own state, cost and normal equations |
//! | [`minimise`] | residuals as a function, derivatives by differences, each unknown within its range |
//! | [`linear`] | the combination of columns nearest to targets |
//! | [`covariance`] | what a Jacobian leaves uncertain |

mod band;
mod bordered;
mod descent;
mod minimise;
mod ordering;

pub(crate) use band::{Band, Factor};
pub(crate) use bordered::{Bordered, BorderedFactor};
pub(crate) use descent::{Descent, Normal, Rules, descend, unbounded};
pub(crate) use minimise::{Scale, covariance, linear, minimise};
pub(crate) use ordering::reverse_cuthill_mckee;
