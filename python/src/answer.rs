//! Answers: one class for all of them; what a form costs is paid when it is asked for.

use std::sync::Arc;

use gearwise::ask;
use gearwise::ask::optimize::Optimized;
use gearwise::input::Source;
use gearwise::report::html;
use gearwise::report::plot::{self, Figure};
use gearwise::requirement::Robot;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde_json::{Value, json};

use crate::failure::wrong;
use crate::pool::here;
use crate::values::python;

/// A choice, with the requirement that it answers.
#[derive(Clone)]
pub struct Chosen {
    /// What was chosen.
    pub found: Arc<Optimized>,
    /// The requirement's text.
    pub source: Arc<Source>,
    /// What it says.
    pub robot: Arc<Robot>,
}

/// An answer of any question.
#[pyclass(frozen, module = "gearwise._native")]
pub struct Answer {
    answer: Arc<dyn ask::Answer>,
    /// The same where it is a choice, with the requirement that it answers.
    choice: Option<Chosen>,
}

impl Answer {
    /// Of an answer of the library.
    pub fn new(answer: impl ask::Answer + 'static) -> Answer {
        Answer { answer: Arc::new(answer), choice: None }
    }

    /// Of a choice.
    pub fn of_choice(found: Optimized, source: Arc<Source>, robot: Arc<Robot>) -> Answer {
        let found = Arc::new(found);
        Answer { answer: found.clone(), choice: Some(Chosen { found, source, robot }) }
    }

    /// The choice, where it is one.
    pub fn choice(&self) -> Option<&Chosen> {
        self.choice.as_ref()
    }

    fn figure(&self, py: Python<'_>) -> PyResult<Figure> {
        let figure = here(py, || Ok(self.answer.figure()))?;
        figure.ok_or_else(|| wrong(py, "this answer has no figure"))
    }
}

#[pymethods]
impl Answer {
    #[getter]
    fn satisfied(&self) -> bool {
        self.answer.is_satisfied()
    }

    fn warnings(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        here(py, || Ok([self.answer.remarks(), self.answer.page().warnings].concat()))
    }

    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let value = here(py, || Ok(self.answer.json()))?;
        python(py, &value)
    }

    fn to_json(&self, py: Python<'_>) -> PyResult<String> {
        here(py, || Ok(self.answer.json_text()))
    }

    fn csv(&self, py: Python<'_>) -> PyResult<String> {
        here(py, || Ok(self.answer.csv_text()))
    }

    fn text(&self, py: Python<'_>) -> PyResult<String> {
        here(py, || Ok(self.answer.text()))
    }

    /// The text with more of it: what binds, why not the others, all of it. Of a choice.
    fn text_of(&self, py: Python<'_>, why: bool, rejected: bool, full: bool) -> PyResult<String> {
        let Some(chosen) = &self.choice else { return self.text(py) };
        here(py, || Ok(chosen.found.text_with(why, rejected, full)))
    }

    fn html(&self, py: Python<'_>, call: &str) -> PyResult<String> {
        here(py, || Ok(html::text(&self.answer.whole_page(call))))
    }

    fn headline(&self, py: Python<'_>) -> PyResult<String> {
        here(py, || Ok(self.answer.page().headline))
    }

    fn svg(&self, py: Python<'_>) -> PyResult<String> {
        let figure = self.figure(py)?;
        here(py, || Ok(plot::svg(&figure)))
    }

    fn png<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let figure = self.figure(py)?;
        let png = here(py, || plot::png(&figure).map_err(ask::Failure::Argument))?;
        Ok(PyBytes::new(py, &png))
    }

    fn figure_data<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let figure = self.figure(py)?;
        python(py, &data(&figure))
    }

    fn joints(&self) -> Vec<String> {
        let names = |of: &Chosen| of.found.robot().joints.iter().map(|j| j.name.clone()).collect();
        self.choice.as_ref().map(names).unwrap_or_default()
    }

    fn candidates(&self, joint: usize) -> usize {
        let of = self.choice.as_ref().and_then(|of| of.found.found().result.joints.get(joint));
        of.map_or(0, |of| of.candidates.len())
    }

    /// That a joint has no design, and what came nearest; empty where it has one.
    fn without(&self, py: Python<'_>, joint: usize) -> PyResult<String> {
        here(py, || Ok(self.choice.as_ref().and_then(|of| of.found.without(joint)).unwrap_or_default()))
    }

    /// One candidate as the JSON has it; None where there is none.
    fn design<'py>(&self, py: Python<'py>, joint: usize, place: usize) -> PyResult<Option<Bound<'py, PyAny>>> {
        let value = self.choice.as_ref().and_then(|of| of.found.design_json(joint, place));
        value.map(|value| python(py, &value)).transpose()
    }
}

/// A figure as data: groups of panels of series.
fn data(figure: &Figure) -> Value {
    let series = |series: &plot::Series| {
        let (x, y): (Vec<f64>, Vec<f64>) = series.points.iter().copied().unzip();
        json!({ "name": series.name, "x": x, "y": y })
    };
    let panel = |panel: &plot::Panel| {
        let all: Vec<Value> = panel.series.iter().map(series).collect();
        json!({ "title": panel.title, "x": panel.x.label, "y": panel.y.label, "series": all })
    };
    let group = |group: &plot::Group| {
        let panels: Vec<Value> = group.panels.iter().map(panel).collect();
        json!({ "title": group.title, "panels": panels })
    };
    let groups: Vec<Value> = figure.groups.iter().map(group).collect();
    json!({ "title": figure.title, "description": figure.description, "groups": groups })
}
