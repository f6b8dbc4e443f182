//! The native part of the Python module `slipstream`: recordings, diagnoses, runs, controllers, traces and studies. Answers leave as JSON
//! text, columns as bytes; `slipstream/*.py` makes typed objects and arrays of them.

mod columns;
mod controllers;
mod diagnosis;
mod errors;
mod interruptible;
mod recording;
mod runs;

use pyo3::prelude::*;

#[pymodule]
fn _slipstream(py: Python<'_>, module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("InputError", py.get_type::<errors::InputError>())?;
    module.add("Failed", py.get_type::<errors::Failed>())?;
    module.add_class::<recording::Recording>()?;
    module.add_class::<diagnosis::Diagnosis>()?;
    module.add_class::<controllers::Context>()?;
    module.add_class::<controllers::OuterInput>()?;
    module.add_class::<controllers::InnerInput>()?;
    module.add_class::<controllers::Heard>()?;
    module.add_function(wrap_pyfunction!(controllers::run_agent, module)?)?;
    module.add_function(wrap_pyfunction!(recording::model_text, module)?)?;
    module.add_function(wrap_pyfunction!(diagnosis::diagnose, module)?)?;
    module.add_function(wrap_pyfunction!(runs::run, module)?)?;
    module.add_function(wrap_pyfunction!(runs::trace, module)?)?;
    module.add_function(wrap_pyfunction!(runs::study, module)?)?;
    module.add_function(wrap_pyfunction!(runs::effects, module)?)?;
    Ok(())
}
