//! Failures as exceptions of Python, which are classes of `gearwise._errors`.

use gearwise::ask::Failure;
use gearwise::input::{InputError, Problem};
use pyo3::prelude::*;
use pyo3::types::PyList;

/// The exception of a failure.
pub fn raised(py: Python<'_>, why: Failure) -> PyErr {
    make(py, why).unwrap_or_else(|error| error)
}

fn make(py: Python<'_>, why: Failure) -> PyResult<PyErr> {
    let errors = py.import("gearwise._errors")?;
    let made = match why {
        Failure::Input(all) => {
            let problems = PyList::empty(py);
            let mut text = String::new();
            for error in &all {
                text.push_str(&error.to_string());
                for problem in &error.problems {
                    problems.append(of_problem(&errors, error, problem)?)?;
                }
            }
            errors.getattr("InputError")?.call_method1("_of", (problems, text.trim_end()))?
        }
        Failure::Argument(message) => errors.getattr("InputError")?.call_method1("_said", (in_python(&message),))?,
        Failure::Interrupted(message) => errors.getattr("GearwiseError")?.call1((message,))?,
    };
    Ok(PyErr::from_value(made))
}

/// What a message calls an option of the command, as the parameter that Python has for it.
fn in_python(message: &str) -> String {
    const SWITCHES: [&str; 4] = ["resume", "force", "robot", "only-checked"];
    let mut parts = message.split("`--");
    let mut text = parts.next().unwrap_or_default().to_string();
    for part in parts {
        let end = part.find(|c: char| !(c.is_ascii_lowercase() || c == '-')).unwrap_or(part.len());
        let (option, rest) = part.split_at(end);
        let value = if SWITCHES.contains(&option) { "=True" } else { "" };
        text.push_str(&format!("`{}{value}{rest}", option.replace('-', "_")));
    }
    text
}

fn of_problem<'py>(
    errors: &Bound<'py, PyModule>,
    error: &InputError,
    problem: &Problem,
) -> PyResult<Bound<'py, PyAny>> {
    let source = &error.source;
    let place = problem.span.as_ref().filter(|_| !source.is_of_values()).map(|span| source.position(span.start));
    let (line, column) = (place.map(|p| p.0), place.map(|p| p.1));
    let (file, key) = match source.is_of_values() {
        true => (None, Some(source.place(problem).trim().to_string()).filter(|key| !key.is_empty())),
        false => (Some(source.name()), None),
    };
    let (message, label, help) = (&problem.message, &problem.label, problem.help.as_ref());
    errors.getattr("Problem")?.call1((message, label, help, file, line, column, key))
}

/// The exception of a mistake of ours.
pub fn internal(py: Python<'_>, said: &str) -> PyErr {
    let make = || -> PyResult<PyErr> {
        let class = py.import("gearwise._errors")?.getattr("InternalError")?;
        let text =
            format!("gearwise {}: {said}; this is a mistake of gearwise, please report it", env!("CARGO_PKG_VERSION"));
        Ok(PyErr::from_value(class.call1((text,))?))
    };
    make().unwrap_or_else(|error| error)
}

/// The exception of a mistake in what was handed over.
pub fn wrong(py: Python<'_>, message: impl Into<String>) -> PyErr {
    raised(py, Failure::Argument(message.into()))
}
