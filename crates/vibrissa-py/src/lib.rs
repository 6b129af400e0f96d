//! The extension module of the Python package `vibrissa`: the crossing between NumPy and the library, and nothing else.
//!
//! | file | what it brings over |
//! | --- | --- |
//! | `arrays`, `error`, `long` | numbers, errors, and work that takes a while |
//! | `inputs` | whiskers and robots |
//! | `beam` | loaded whiskers |
//! | `world`, `log` | maps, sensor logs |
//! | `readings` | contact sets and preimages |
//! | `localizer` | a localizer that takes rows as they come |
//! | `localize`, `plan`, `simulate`, `contacts`, `mapping`, `calibrate` | the tasks of these names |
//!
//! The public face with its docstrings, types and defaults of arguments is Python, in `python/vibrissa`.

mod arrays;
mod beam;
mod calibrate;
mod contacts;
mod error;
mod inputs;
mod localize;
mod localizer;
mod log;
mod long;
mod mapping;
mod plan;
mod readings;
mod simulate;
mod world;

use pyo3::prelude::*;

/// Runs the command line `args`, the program's name first, and gives its exit code.
#[pyfunction]
fn run_command(py: Python<'_>, args: Vec<String>) -> PyResult<u8> {
    long::run(py, None, 0, move |_| Ok(vibrissa_cli::run(args)))
}

/// The same on this thread, for a process that is the command: Ctrl-C ends it.
#[pyfunction]
fn run_command_here(py: Python<'_>, args: Vec<std::ffi::OsString>) -> u8 {
    py.detach(|| vibrissa_cli::run(args))
}

/// The extension module of the package vibrissa.
#[pymodule]
mod _vibrissa {
    #[pymodule_export]
    use super::{run_command, run_command_here};
    #[pymodule_export]
    use crate::beam::{Bend, Bends, bends};
    #[pymodule_export]
    use crate::calibrate::{PyCalibration, calibrate_labelled, calibrate_staircase, calibrate_taps, find_taps};
    #[pymodule_export]
    use crate::contacts::{contact, contact_in_space, profile, temporal_filter};
    #[pymodule_export]
    use crate::inputs::{quantity, robot_default, robot_parse, robot_read, robot_toml, whisker_is_uniform};
    #[pymodule_export]
    use crate::localize::{demo_sweep, localize, methods, tum_error, tum_format, tum_read};
    #[pymodule_export]
    use crate::localizer::PyLocalizer;
    #[pymodule_export]
    use crate::log::PySensorLog;
    #[pymodule_export]
    use crate::mapping::map_log;
    #[pymodule_export]
    use crate::plan::{explore, plan};
    #[pymodule_export]
    use crate::readings::{contact_set, preimage};
    #[pymodule_export]
    use crate::simulate::{PyScenario, path, sweep};
    #[pymodule_export]
    use crate::world::PyMap;
    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
