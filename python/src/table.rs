//! Tables: the CSV of an answer as columns.

use std::sync::Arc;

use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::{ArrayRef, BooleanArray, Float64Array, Int64Array, RecordBatch, RecordBatchIterator, StringArray};
use gearwise::report::columns::{Kind, columns};
use numpy::PyArray1;
use pyo3::ffi::c_str;
use pyo3::prelude::*;
use pyo3::types::{PyCapsule, PyDict, PyList};

use crate::failure::{internal, wrong};

/// Columns of one length with names.
#[pyclass(frozen, module = "gearwise._native")]
pub struct Table {
    columns: Vec<(String, Column)>,
    rows: usize,
}

/// Columns of texts, of tables that are no designs.
const TEXTS: &[&str] = &["id", "motor", "gear", "manufacturer", "model", "code", "message", "explanation", "name"];

/// The cells of a column.
enum Column {
    /// Numbers; NaN where nothing is known.
    Numbers(Vec<f64>),
    /// Whole numbers, all of them known.
    Whole(Vec<i64>),
    /// True or false, all of them known.
    Flags(Vec<bool>),
    /// Texts; `None` where the cell is empty.
    Texts(Vec<Option<String>>),
}

impl Column {
    /// Of the cells of a CSV file. What a column holds goes by its name where that is known, so that it is the same whatever
    /// is in it.
    fn of(name: &str, cells: Vec<&str>) -> Column {
        let known = columns().iter().find(|column| column.key == name).map(|column| column.kind);
        if known == Some(Kind::Text) || TEXTS.contains(&name) {
            let text = |cell: &&str| (!cell.is_empty()).then(|| (*cell).to_string());
            return Column::Texts(cells.iter().map(text).collect());
        }
        if known == Some(Kind::Number) {
            return Column::Numbers(cells.iter().map(|cell| cell.parse().unwrap_or(f64::NAN)).collect());
        }
        let filled = || cells.iter().filter(|cell| !cell.is_empty());
        let all = filled().count() == cells.len() && !cells.is_empty();
        if all && cells.iter().all(|cell| matches!(*cell, "true" | "false")) {
            return Column::Flags(cells.iter().map(|cell| *cell == "true").collect());
        }
        let whole: Option<Vec<i64>> = cells.iter().map(|cell| cell.parse().ok()).collect();
        if let Some(whole) = whole.filter(|_| all) {
            return Column::Whole(whole);
        }
        let number = |cell: &&str| if cell.is_empty() { Some(f64::NAN) } else { cell.parse().ok() };
        let numbers: Option<Vec<f64>> = cells.iter().map(number).collect();
        match numbers.filter(|_| filled().next().is_some()) {
            Some(numbers) => Column::Numbers(numbers),
            None => {
                let text = |cell: &&str| (!cell.is_empty()).then(|| (*cell).to_string());
                Column::Texts(cells.iter().map(text).collect())
            }
        }
    }

    fn only(&self, keep: &[bool]) -> Column {
        fn kept<T: Clone>(values: &[T], keep: &[bool]) -> Vec<T> {
            values.iter().zip(keep).filter(|(_, keep)| **keep).map(|(value, _)| value.clone()).collect()
        }
        match self {
            Column::Numbers(values) => Column::Numbers(kept(values, keep)),
            Column::Whole(values) => Column::Whole(kept(values, keep)),
            Column::Flags(values) => Column::Flags(kept(values, keep)),
            Column::Texts(values) => Column::Texts(kept(values, keep)),
        }
    }

    fn arrow(&self) -> ArrayRef {
        match self {
            // What is not known is null there.
            Column::Numbers(values) => {
                Arc::new(values.iter().map(|value| (!value.is_nan()).then_some(*value)).collect::<Float64Array>())
            }
            Column::Whole(values) => Arc::new(Int64Array::from(values.clone())),
            Column::Flags(values) => Arc::new(BooleanArray::from(values.clone())),
            Column::Texts(values) => Arc::new(StringArray::from(values.clone())),
        }
    }
}

#[pymethods]
impl Table {
    /// The table of a CSV text whose first row has the names of its columns.
    #[new]
    fn new(py: Python<'_>, csv: &str) -> PyResult<Table> {
        let wrong = |why: String| wrong(py, format!("the table cannot be read: {why}"));
        let mut lines = records(csv).into_iter();
        let header = lines.next().ok_or_else(|| wrong("it has no header".into()))?;
        let rows: Vec<Vec<String>> = lines.collect();
        if rows.iter().any(|row| row.len() != header.len()) {
            return Err(wrong("its rows are not of one length".into()));
        }
        let cells = |k: usize| rows.iter().map(|row| row[k].as_str()).collect();
        let columns = header.iter().enumerate().map(|(k, name)| (name.clone(), Column::of(name, cells(k)))).collect();
        Ok(Table { columns, rows: rows.len() })
    }

    fn __len__(&self) -> usize {
        self.rows
    }

    #[getter]
    fn names(&self) -> Vec<String> {
        self.columns.iter().map(|(name, _)| name.clone()).collect()
    }

    /// The rows whose cell in a column of texts is this.
    fn only(&self, py: Python<'_>, name: &str, text: &str) -> PyResult<Table> {
        let Some((_, Column::Texts(cells))) = self.columns.iter().find(|(known, _)| known == name) else {
            return Err(wrong(py, format!("there is no column of texts `{name}`")));
        };
        let keep: Vec<bool> = cells.iter().map(|cell| cell.as_deref() == Some(text)).collect();
        let columns = self.columns.iter().map(|(name, column)| (name.clone(), column.only(&keep))).collect();
        Ok(Table { columns, rows: keep.iter().filter(|keep| **keep).count() })
    }

    fn columns<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for (name, column) in &self.columns {
            let array = match column {
                Column::Numbers(values) => PyArray1::from_slice(py, values).into_any(),
                Column::Whole(values) => PyArray1::from_slice(py, values).into_any(),
                Column::Flags(values) => PyArray1::from_slice(py, values).into_any(),
                Column::Texts(values) => {
                    let options = PyDict::new(py);
                    let numpy = py.import("numpy")?;
                    options.set_item("dtype", numpy.getattr("object_")?)?;
                    let list = PyList::new(py, values)?;
                    numpy.call_method("array", (list,), Some(&options))?
                }
            };
            dict.set_item(name, array)?;
        }
        Ok(dict)
    }

    /// The Arrow C stream of the table, for pyarrow, polars and others.
    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        // A producer may give its own schema where another is wished.
        let _ = requested_schema;
        let columns = self.columns.iter().map(|(name, column)| (name.clone(), column.arrow(), true));
        let batch = RecordBatch::try_from_iter_with_nullable(columns).map_err(|why| internal(py, &why.to_string()))?;
        let schema = batch.schema();
        let reader = RecordBatchIterator::new([Ok(batch)], schema);
        let stream = FFI_ArrowArrayStream::new(Box::new(reader));
        PyCapsule::new_with_value(py, stream, c_str!("arrow_array_stream"))
    }
}

/// The records of a CSV text.
fn records(text: &str) -> Vec<Vec<String>> {
    let mut reader = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(text.as_bytes());
    let record = |record: csv::StringRecord| record.iter().map(String::from).collect();
    reader.records().map_while(Result::ok).map(record).collect()
}
