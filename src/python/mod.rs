//! The Python module `morpho_fit._engine`: the same library over numpy arrays. Its Python side is `morpho_fit/`.
//!
//! Numbers are in the units of the command line: nm, degrees, and radians for `phi_alpha`. Work is done with the interpreter's
//! lock released, and what can go wrong is an exception with a type of its own ([`errors`]). No file is opened here: Python
//! opens it.
#![allow(clippy::doc_markdown, reason = "the comments are docstrings, which Python shows as they are")]

mod arrays;
mod colour;
mod constant;
mod data;
mod errors;
mod fit;
mod forward;
mod intervals;
mod map;
mod model;
mod objective;
mod patience;
mod settings;
mod structure;
mod words;

/// What `import morpho_fit._engine` finds.
#[pyo3::pymodule]
#[pyo3(name = "_engine")]
mod engine {
    #[pymodule_export]
    use super::colour::{Colours, colour, sweep};
    #[pymodule_export]
    use super::constant::fit_constant;
    #[pymodule_export]
    use super::errors::{DataError, FitError, OpticsError};
    #[pymodule_export]
    use super::fit::{FitResult, fit};
    #[pymodule_export]
    use super::forward::{contributions, multilayer_reflectivity, reflectivity};
    #[pymodule_export]
    use super::intervals::{Posterior, ProfileFound};
    #[pymodule_export]
    use super::map::fit_map;
    #[pymodule_export]
    use super::model::{Averages, Cauchy, IndexTable, Model, Stack};
    #[pymodule_export]
    use super::objective::Objective;
    #[pymodule_export]
    use super::structure::Structure;

    #[pymodule_init]
    fn init(module: &pyo3::Bound<'_, pyo3::types::PyModule>) -> pyo3::PyResult<()> {
        use pyo3::types::PyModuleMethods;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
