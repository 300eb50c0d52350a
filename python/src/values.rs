//! Values of Python as TOML, and JSON as values of Python.

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyMapping, PySequence, PyString, PyTuple};
use serde_json::Value;

use crate::failure::wrong;
use crate::motion::Motion;

/// What a value is that is no motion's; motions are put aside under names that stand in their place.
pub struct Writer<'py> {
    py: Python<'py>,
    /// The motions that stand in the values.
    pub motions: Vec<(String, Py<Motion>)>,
}

/// Values inside values, at most.
const DEEP: usize = 16;
/// Entries of a list, at most.
const LONG: usize = 100_000;

impl<'py> Writer<'py> {
    /// Of no values yet.
    pub fn new(py: Python<'py>) -> Writer<'py> {
        Writer { py, motions: Vec::new() }
    }

    /// A mapping as the text of a TOML file.
    pub fn file(&mut self, value: &Bound<'py, PyAny>) -> PyResult<String> {
        match self.value(value, "", 0)? {
            Some(toml::Value::Table(table)) => {
                toml::to_string(&table).map_err(|why| wrong(self.py, format!("the values are no table: {why}")))
            }
            _ => Err(wrong(self.py, "the values are no table: expected a mapping of names to values")),
        }
    }

    /// One value as TOML; `None` for None. `key` is where it stands, for messages.
    pub fn value(&mut self, value: &Bound<'py, PyAny>, key: &str, depth: usize) -> PyResult<Option<toml::Value>> {
        let py = self.py;
        let refused = |what: String| {
            let at = if key.is_empty() { "the values".to_string() } else { format!("`{key}`") };
            wrong(py, format!("{at}: {what}"))
        };
        if depth > DEEP {
            return Err(refused("tables and lists are nested too deep".into()));
        }
        if value.is_none() {
            return Ok(None);
        }
        if let Ok(motion) = value.cast::<Motion>() {
            return Ok(Some(toml::Value::String(self.stand_in(motion))));
        }
        if value.is_instance_of::<PyBool>() {
            return Ok(Some(toml::Value::Boolean(value.extract()?)));
        }
        if let Ok(text) = value.cast::<PyString>() {
            return Ok(Some(toml::Value::String(text.to_str().map_err(|_| refused("is no text".into()))?.to_string())));
        }
        if value.is_instance_of::<PyInt>() {
            let number = value.extract::<i64>().map_err(|_| refused(format!("{value} is too large")))?;
            return Ok(Some(toml::Value::Integer(number)));
        }
        if value.is_instance_of::<PyFloat>() {
            return Ok(Some(toml::Value::Float(value.extract()?)));
        }
        // Tables of words have a method that gives them as a mapping; a path is its text.
        if let Ok(table) = value.getattr("_table") {
            let table = table.call0()?;
            return self.value(&table, key, depth + 1);
        }
        if let Ok(path) = value.getattr("__fspath__") {
            let path = path.call0()?;
            let text = path.cast::<PyString>().map_err(|_| refused("is a path of bytes: expected text".into()))?;
            return Ok(Some(toml::Value::String(text.to_str()?.to_string())));
        }
        if let Ok(mapping) = value.cast::<PyMapping>() {
            let mut table = toml::Table::new();
            for item in mapping.items()?.iter() {
                let (name, item): (Bound<PyAny>, Bound<PyAny>) = item.extract()?;
                let name = name.cast::<PyString>().map_err(|_| refused(format!("the key {name} is no text")))?;
                let name = name.to_str()?;
                let inner = if key.is_empty() { name.to_string() } else { format!("{key}.{name}") };
                if let Some(item) = self.value(&item, &inner, depth + 1)? {
                    table.insert(name.to_string(), item);
                }
            }
            return Ok(Some(toml::Value::Table(table)));
        }
        // Scalars of NumPy and the like say what they are as numbers.
        if value.cast::<PySequence>().is_err()
            && let Some(number) = self.number(value)?
        {
            return Ok(Some(number));
        }
        let items = match value.try_iter() {
            Ok(items) if value.hasattr("__len__")? && value.len().is_ok() => items,
            _ => {
                let kind = value.get_type().name()?;
                return Err(refused(format!("a {kind} is no value: expected text, a number, a list or a table")));
            }
        };
        if value.len()? > LONG {
            return Err(refused(format!("more than {LONG} entries")));
        }
        let mut list = Vec::new();
        for (place, item) in items.enumerate() {
            let inner = format!("{key}[{place}]");
            match self.value(&item?, &inner, depth + 1)? {
                Some(item) => list.push(item),
                None => return Err(wrong(self.py, format!("`{inner}`: None is no entry of a list"))),
            }
        }
        Ok(Some(toml::Value::Array(list)))
    }

    /// A number of another kind than Python's own.
    fn number(&self, value: &Bound<'py, PyAny>) -> PyResult<Option<toml::Value>> {
        if value.hasattr("__index__")? && value.hasattr("__int__")? && !value.hasattr("__len__")? {
            let number = value.call_method0("__index__")?;
            return Ok(number.extract::<i64>().ok().map(toml::Value::Integer));
        }
        if value.hasattr("__float__")? && value.len().is_err() {
            let number = value.call_method0("__float__")?;
            return Ok(number.extract::<f64>().ok().map(toml::Value::Float));
        }
        Ok(None)
    }

    /// The name that stands for a motion.
    fn stand_in(&mut self, motion: &Bound<'py, Motion>) -> String {
        if let Some((name, _)) = self.motions.iter().find(|(_, known)| known.is(motion)) {
            return name.clone();
        }
        let name = stand_in(motion);
        self.motions.push((name.clone(), motion.clone().unbind()));
        name
    }
}

/// The name that stands for a motion wherever it is used: by what it is.
pub fn stand_in(motion: &Bound<Motion>) -> String {
    format!("motion {}", motion.get().id())
}

/// JSON as Python has it.
pub fn python<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        Value::Null => py.None().into_bound(py),
        Value::Bool(value) => PyBool::new(py, *value).to_owned().into_any(),
        Value::Number(number) => match (number.as_i64(), number.as_u64(), number.as_f64()) {
            (Some(whole), ..) => whole.into_pyobject(py)?.into_any(),
            (None, Some(whole), _) => whole.into_pyobject(py)?.into_any(),
            (None, None, Some(number)) => PyFloat::new(py, number).into_any(),
            _ => return Err(PyTypeError::new_err("a number that is none")),
        },
        Value::String(text) => PyString::new(py, text).into_any(),
        Value::Array(items) => {
            let list = PyList::empty(py);
            for item in items {
                list.append(python(py, item)?)?;
            }
            list.into_any()
        }
        Value::Object(entries) => {
            let dict = PyDict::new(py);
            for (key, item) in entries {
                dict.set_item(key, python(py, item)?)?;
            }
            dict.into_any()
        }
    })
}

/// A sequence of texts, or one text.
pub fn texts(py: Python<'_>, what: &str, value: &Bound<PyAny>) -> PyResult<Vec<String>> {
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(vec![text.to_str()?.to_string()]);
    }
    let all = value.cast::<PyTuple>().map_or_else(|_| value.extract::<Vec<String>>(), |tuple| tuple.extract());
    all.map_err(|_| wrong(py, format!("`{what}` is neither text nor a list of texts")))
}
