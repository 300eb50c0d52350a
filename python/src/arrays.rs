//! Answers that are arrays.

use gearwise::ask::{actuator_map, evaluate};
use gearwise::design::simulated::Figures;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Numbers as an array of a shape, the last axis fastest.
fn shaped<'py, T: numpy::Element>(py: Python<'py>, values: Vec<T>, shape: &[usize]) -> PyResult<Bound<'py, PyAny>> {
    let array = PyArray1::from_vec(py, values);
    Ok(array.reshape(shape.to_vec())?.into_any())
}

fn reasons<'py>(py: Python<'py>, unusable: &[(String, String)]) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    unusable.iter().try_for_each(|(motor, why)| dict.set_item(motor, why))?;
    Ok(dict)
}

/// Designs over (motor, ratio).
#[pyclass(frozen, module = "gearwise._native")]
pub struct Evaluated(pub evaluate::Evaluated);

impl Evaluated {
    fn plane<'py>(&self, py: Python<'py>, values: &[f64]) -> PyResult<Bound<'py, PyAny>> {
        shaped(py, values.to_vec(), &[self.0.motors.len(), self.0.ratio.len()])
    }
}

#[pymethods]
impl Evaluated {
    #[getter]
    fn motors(&self) -> Vec<String> {
        self.0.motors.clone()
    }

    #[getter]
    fn ratio<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        shaped(py, self.0.ratio.clone(), &[self.0.ratio.len()])
    }

    #[getter]
    fn unusable<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        reasons(py, &self.0.unusable)
    }

    #[getter]
    fn unknown_losses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        let known = self.0.motors.iter().zip(&self.0.unknown_losses).filter(|(_, parts)| !parts.is_empty());
        known.into_iter().try_for_each(|(motor, parts)| dict.set_item(motor, parts.clone()))?;
        Ok(dict)
    }

    #[getter]
    fn feasible<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        shaped(py, self.0.feasible.clone(), &[self.0.motors.len(), self.0.ratio.len()])
    }

    #[getter]
    fn judged<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        shaped(py, self.0.judged.clone(), &[self.0.motors.len(), self.0.ratio.len()])
    }

    #[getter]
    fn loss_w<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.plane(py, &self.0.loss)
    }

    #[getter]
    fn loss_slope_w<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.plane(py, &self.0.loss_slope)
    }

    #[getter]
    fn peak_current_q_a<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.plane(py, &self.0.peak_current)
    }

    #[getter]
    fn rms_current_q_a<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.plane(py, &self.0.rms_current)
    }

    #[getter]
    fn mean_electrical_power_w<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.plane(py, &self.0.mean_electrical_power)
    }

    #[getter]
    fn reflected_inertia_kgm2<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.plane(py, &self.0.reflected_inertia)
    }

    #[getter]
    fn mass_kg<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.plane(py, &self.0.mass)
    }

    #[getter]
    fn objective<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.plane(py, &self.0.objective)
    }

    #[getter]
    fn limits(&self) -> Vec<&'static str> {
        self.0.limits.clone()
    }

    #[getter]
    fn margin<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        shaped(py, self.0.margin.clone(), &[self.0.motors.len(), self.0.ratio.len(), self.0.limits.len()])
    }

    #[getter]
    fn sample<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        shaped(py, self.0.sample.clone(), &[self.0.motors.len(), self.0.ratio.len(), self.0.limits.len()])
    }
}

/// Actuators over (motor, ratio).
#[pyclass(frozen, module = "gearwise._native")]
pub struct ActuatorMap(pub actuator_map::ActuatorMap);

#[pymethods]
impl ActuatorMap {
    #[getter]
    fn motors(&self) -> Vec<String> {
        self.0.motors.clone()
    }

    #[getter]
    fn ratio<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        shaped(py, self.0.ratio.clone(), &[self.0.ratio.len()])
    }

    #[getter]
    fn unusable<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        reasons(py, &self.0.unusable)
    }

    /// One figure over (motor, ratio), by its name.
    fn figure<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        let Some((_, of)) = FIGURES.iter().find(|(known, _)| *known == name) else { return Ok(None) };
        let values = self.0.figures.iter().map(|figures| figures.as_ref().map_or(f64::NAN, of)).collect();
        shaped(py, values, &[self.0.motors.len(), self.0.ratio.len()]).map(Some)
    }

    /// A row for each motor and ratio, as CSV.
    fn csv(&self) -> String {
        let names = FIGURES.iter().map(|(name, _)| *name);
        let mut rows = vec![["motor", "ratio"].into_iter().chain(names).map(String::from).collect::<Vec<_>>()];
        let ratios = self.0.ratio.len();
        for (place, figures) in self.0.figures.iter().enumerate() {
            let number = |value: f64| if value.is_nan() { String::new() } else { value.to_string() };
            let of = |(_, of): &Named| number(figures.as_ref().map_or(f64::NAN, of));
            let (motor, ratio) = (&self.0.motors[place / ratios], self.0.ratio[place % ratios]);
            rows.push([motor.clone(), ratio.to_string()].into_iter().chain(FIGURES.iter().map(of)).collect());
        }
        let mut writer = csv::Writer::from_writer(Vec::new());
        if rows.iter().any(|row| writer.write_record(row).is_err()) {
            return String::new();
        }
        writer.into_inner().ok().and_then(|bytes| String::from_utf8(bytes).ok()).unwrap_or_default()
    }

    /// Names of the figures.
    #[staticmethod]
    fn figures() -> Vec<&'static str> {
        FIGURES.iter().map(|(name, _)| *name).collect()
    }

    /// Torque driving and braking over (motor, ratio, speed).
    fn envelope<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let (motors, ratios) = (self.0.motors.len(), self.0.ratio.len());
        let speeds = self.0.driving.len() / (motors * ratios).max(1);
        let shape = [motors, ratios, speeds];
        Ok((shaped(py, self.0.driving.clone(), &shape)?, shaped(py, self.0.braking.clone(), &shape)?))
    }
}

/// A figure by its name.
type Named = (&'static str, fn(&Figures) -> f64);

const FIGURES: &[Named] = &[
    ("mass_kg", |f| f.mass),
    ("reflected_inertia_kgm2", |f| f.reflected_inertia),
    ("copper_loss_w_per_nm2", |f| f.copper_loss_per_torque_squared),
    ("peak_torque_nm", |f| f.peak_torque),
    ("peak_braking_torque_nm", |f| f.peak_braking_torque),
    ("continuous_torque_nm", |f| f.continuous_torque),
    ("stall_torque_nm", |f| f.stall_torque),
    ("speed_at_peak_rad_per_s", |f| f.speed_at_peak),
    ("no_load_speed_rad_per_s", |f| f.no_load_speed),
    ("max_speed_rad_per_s", |f| f.max_speed),
    ("damping_nms_per_rad", |f| f.damping),
    ("friction_loss_nm", |f| f.friction_loss),
];
