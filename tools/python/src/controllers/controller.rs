//! A Python object as a controller.

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyString;
use slipstream_agents::{
    AgentContext, Controller, ControllerError, DesiredTwist, InnerInput, OuterInput, WheelTorques,
};
use slipstream_bus::experiment::{ParameterValue, Parameters};
use slipstream_bus::message::{Extra, MAX_EXTRA};

use super::context::Context;
use super::input;
use super::watch::Watch;

/// A Python object as a controller.
pub(crate) struct PythonController {
    object: Py<PyAny>,
    /// Whether it has an inner loop and a message of its own.
    has_inner: bool,
    has_message: bool,
    extra: Extra,
    /// Who waits for the run in this process. Without it, an exception is told with its traceback.
    watch: Option<Watch>,
}

impl PythonController {
    /// Makes the controller of a robot. `made` is a controller, or makes one when it is called.
    pub(crate) fn new(
        made: &Py<PyAny>,
        context: &AgentContext<'_>,
        watch: Option<Watch>,
    ) -> Result<Self, ControllerError> {
        Python::attach(|py| {
            let failed = |error: PyErr| ControllerError::Failed(told(py, error, watch.as_ref()));
            let made = made.bind(py);
            let object = match made.hasattr("outer").map_err(failed)? && !is_class(made) {
                true => made.clone(),
                false => made.call0().map_err(failed)?,
            };
            let defaults = parameters(&object).map_err(failed)?;
            for (name, value) in context.merge(defaults)? {
                set(&object, &name, value).map_err(failed)?;
            }
            let known = Bound::new(py, Context::new(context)?).map_err(failed)?;
            if object.hasattr("start").map_err(failed)? {
                object.call_method1("start", (known,)).map_err(failed)?;
            }
            let has = |name: &str| overrides(&object, name);
            let [has_inner, has_message] = [has("inner"), has("message")];
            Ok(Self {
                has_inner: has_inner.map_err(failed)?,
                has_message: has_message.map_err(failed)?,
                object: object.unbind(),
                extra: Extra::default(),
                watch,
            })
        })
    }

    /// Calls Python; an exception becomes the error.
    fn call<T>(
        &self,
        call: impl FnOnce(&Bound<'_, PyAny>) -> PyResult<T>,
    ) -> Result<T, ControllerError> {
        if let Some(watch) = &self.watch {
            watch.stop.check();
        }
        Python::attach(|py| {
            call(self.object.bind(py))
                .map_err(|error| ControllerError::Failed(told(py, error, self.watch.as_ref())))
        })
    }
}

impl Controller for PythonController {
    fn outer(&mut self, now: &OuterInput<'_>) -> Result<DesiredTwist, ControllerError> {
        let has_message = self.has_message;
        let (desired, extra) = self.call(|object| {
            let py = object.py();
            let now = Bound::new(py, input::OuterInput::new(py, now)?)?;
            let given = object.call_method1(pyo3::intern!(py, "outer"), (now,))?;
            let (v, w) = numbers(&given, "outer", "v (m/s) and w (rad/s)")?;
            let extra = match has_message {
                true => message(object)?,
                false => Extra::default(),
            };
            Ok((DesiredTwist { v, w }, extra))
        })?;
        self.extra = extra;
        Ok(desired)
    }

    fn inner(&mut self, now: &InnerInput<'_>) -> Result<WheelTorques, ControllerError> {
        if !self.has_inner {
            return Ok(now.paper());
        }
        let (torques, has_asked) = self.call(|object| {
            let py = object.py();
            let known = Bound::new(py, input::InnerInput::new(now))?;
            let given = object.call_method1(pyo3::intern!(py, "inner"), (&known,))?;
            let (right, left) = numbers(&given, "inner", "the torques right and left (N m)")?;
            Ok(([right, left], known.get().has_asked()))
        })?;
        if !has_asked {
            now.discard();
        }
        Ok(now.limited(torques))
    }

    fn message(&self) -> Extra {
        self.extra
    }
}

/// The two numbers that a method has given.
fn numbers(given: &Bound<'_, PyAny>, method: &str, what: &str) -> PyResult<(f64, f64)> {
    given.extract().map_err(|_: PyErr| {
        let given = given.repr().map(|own| own.to_string()).unwrap_or_default();
        PyTypeError::new_err(format!("{method} gave {given}: give {what}"))
    })
}

/// The numbers that the controller adds to its messages.
fn message(object: &Bound<'_, PyAny>) -> PyResult<Extra> {
    let given = object.call_method0(pyo3::intern!(object.py(), "message"))?;
    if given.is_none() {
        return Ok(Extra::default());
    }
    let numbers: Option<Vec<f64>> = given.extract().ok();
    numbers.and_then(|own| Extra::new(&own)).ok_or_else(|| {
        let given = given.repr().map(|own| own.to_string()).unwrap_or_default();
        PyTypeError::new_err(format!(
            "message gave {given}: give a list of at most {MAX_EXTRA} numbers"
        ))
    })
}

fn is_class(object: &Bound<'_, PyAny>) -> bool {
    object.is_instance_of::<pyo3::types::PyType>()
}

/// The class `Controller` of the module.
fn base<'py>(py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
    py.import("slipstream.controller")?.getattr("Controller")
}

/// Whether the class of an object has a method of its own in place of the one of `Controller`.
fn overrides(object: &Bound<'_, PyAny>, name: &str) -> PyResult<bool> {
    let class = object.get_type();
    if !class.hasattr(name)? {
        return Ok(false);
    }
    Ok(!class.getattr(name)?.is(&base(object.py())?.getattr(name)?))
}

/// The parameters of a controller: the attributes of its classes below `Controller` that are numbers, truth values, texts
/// or lists of numbers and whose names do not begin with `_`, with the values that the object has.
fn parameters(object: &Bound<'_, PyAny>) -> PyResult<Parameters> {
    let base = base(object.py())?;
    let mut parameters = Parameters::new();
    for class in object.get_type().mro().iter() {
        if class.is(&base) || class.is(object.py().get_type::<PyAny>()) {
            break;
        }
        let attributes = class.getattr("__dict__")?;
        for name in attributes.call_method0("keys")?.try_iter()? {
            let Ok(name) = name?.extract::<String>() else {
                continue;
            };
            if name.starts_with('_') || parameters.contains_key(&name) {
                continue;
            }
            // What the class itself has decides whether it is a parameter: a method or a property is none.
            if value(&attributes.get_item(&name)?).is_some()
                && let Some(own) = value(&object.getattr(name.as_str())?)
            {
                parameters.insert(name, own);
            }
        }
    }
    Ok(parameters)
}

/// A value as a parameter, if it can be one.
fn value(value: &Bound<'_, PyAny>) -> Option<ParameterValue> {
    if let Ok(own) = value.cast_exact::<pyo3::types::PyBool>() {
        return Some(ParameterValue::Bool(own.is_true()));
    }
    if value.is_instance_of::<pyo3::types::PyInt>() {
        return value.extract().ok().map(ParameterValue::Integer);
    }
    if value.is_instance_of::<pyo3::types::PyFloat>() {
        return value.extract().ok().map(ParameterValue::Number);
    }
    if let Ok(own) = value.cast::<PyString>() {
        return Some(ParameterValue::Text(own.to_string()));
    }
    let is_list = value.is_instance_of::<pyo3::types::PyList>()
        || value.is_instance_of::<pyo3::types::PyTuple>();
    let numbers = is_list.then(|| value.extract().ok()).flatten();
    numbers.map(ParameterValue::Numbers)
}

fn set(object: &Bound<'_, PyAny>, name: &str, value: ParameterValue) -> PyResult<()> {
    match value {
        ParameterValue::Bool(own) => object.setattr(name, own),
        ParameterValue::Integer(own) => object.setattr(name, own),
        ParameterValue::Number(own) => object.setattr(name, own),
        ParameterValue::Text(own) => object.setattr(name, own),
        ParameterValue::Numbers(own) => object.setattr(name, own),
    }
}

/// What an exception says. Where somebody waits for the exception itself, its traceback comes with it.
fn told(py: Python<'_>, error: PyErr, watch: Option<&Watch>) -> String {
    let said = error.to_string();
    let Some(watch) = watch else {
        return match traceback(py, &error) {
            Ok(text) => format!("{said}\n{}", text.trim_end()),
            Err(_) => said,
        };
    };
    if let Ok(mut slot) = watch.raised.lock() {
        slot.get_or_insert(error);
    }
    said
}

fn traceback(py: Python<'_>, error: &PyErr) -> PyResult<String> {
    let lines = py.import("traceback")?.call_method1(
        "format_exception",
        (error.get_type(py), error.value(py), error.traceback(py)),
    )?;
    let lines: Vec<String> = lines.extract()?;
    Ok(lines.concat())
}
