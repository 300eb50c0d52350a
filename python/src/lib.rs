//! The native part of the Python package `gearwise`: what the Python classes of `python/gearwise` stand on.
//!
//! The one idea: Python sees handles. What is asked goes through the readers of files, what is answered is an
//! [`Answer`](gearwise::ask::Answer) of the library, and each form of it is made when Python asks for it. No physics here,
//! and no words that the library has.

mod answer;
mod arrays;
mod calls;
mod catalog;
mod failure;
mod motion;
mod pool;
mod requirement;
mod studies;
mod table;
mod values;

use pyo3::prelude::*;

/// The native module.
#[pymodule(gil_used = false)]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<answer::Answer>()?;
    module.add_class::<arrays::Evaluated>()?;
    module.add_class::<arrays::ActuatorMap>()?;
    module.add_class::<catalog::Catalog>()?;
    module.add_class::<motion::Motion>()?;
    module.add_class::<requirement::Requirement>()?;
    module.add_class::<table::Table>()?;
    calls::add(module)
}
