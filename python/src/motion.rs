//! Motions from arrays.

use std::hash::{DefaultHasher, Hasher};
use std::sync::{Arc, OnceLock};

use gearwise::ask::Failure;
use gearwise::input::Source;
use gearwise::motion::{self, Course, Point, Samples};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};

use crate::failure::{raised, wrong};
use crate::pool::here;

/// A motion of a joint, shared by every requirement that uses it.
#[pyclass(frozen, module = "gearwise._native")]
pub struct Motion {
    motion: Arc<motion::Motion>,
    /// How it was made, to make it again in another process.
    made: Made,
    id: OnceLock<String>,
    arrays: [OnceLock<Py<PyAny>>; 7],
}

/// How a motion was made: arrays by their names, and what is said of them.
#[derive(Clone)]
struct Made {
    kind: &'static str,
    arrays: Vec<(&'static str, Vec<f64>)>,
    periodic: bool,
    period: Option<f64>,
    scale: (f64, f64),
    /// Name and text of the file that it was read from.
    file: Option<(String, String)>,
}

/// A motion as a file has it.
pub enum Written {
    /// The text of a file of its own, whether the motion repeats, and its period where that is not in the text.
    File(String, bool, Option<f64>),
    /// Operating points.
    Points(Vec<Point>),
}

impl Motion {
    /// As a file has it, and the factors that come on top; `None` for what no file can hold.
    pub fn written(&self) -> Option<(Written, (f64, f64))> {
        let made = &self.made;
        let column = |name: &str| made.arrays.iter().find(|(n, _)| *n == name).map(|(_, values)| values);
        let written = match (made.kind, &made.file) {
            ("file", Some((_, text))) => Written::File(text.clone(), made.periodic, made.period),
            ("samples", _) => Written::File(csv(&made.arrays), made.periodic, made.period),
            ("points", _) => {
                let at = |name: &str, k: usize| column(name).map_or(0.0, |values| values[k]);
                let point = |k: usize| Point {
                    torque: at("torque", k),
                    velocity: at("velocity", k),
                    acceleration: at("acceleration", k),
                    duration: column("duration").map(|values| values[k]),
                    ..Point::default()
                };
                Written::Points((0..self.motion.len()).map(point).collect())
            }
            _ => return None,
        };
        Some((written, made.scale))
    }

    fn of(motion: Arc<motion::Motion>, made: Made) -> Motion {
        Motion { motion, made, id: OnceLock::new(), arrays: Default::default() }
    }

    /// The motion.
    pub fn shared(&self) -> Arc<motion::Motion> {
        self.motion.clone()
    }

    /// The same for the same samples, in any process.
    pub fn id(&self) -> &str {
        self.id.get_or_init(|| {
            let m = &self.motion;
            let mut hash = DefaultHasher::new();
            let length = match m.course {
                Course::Periodic(period) => period,
                Course::Once(duration) => -duration,
                Course::Points(total) => total.unwrap_or(f64::INFINITY),
                Course::Cases => f64::NAN,
            };
            hash.write_u64(length.to_bits());
            for values in [&m.time, &m.torque, &m.velocity, &m.acceleration, &m.torque_rate, &m.jerk, &m.weight] {
                hash.write_usize(values.len());
                values.iter().for_each(|value| hash.write_u64(value.to_bits()));
            }
            format!("{:016x}", hash.finish())
        })
    }

    fn array(&self, py: Python<'_>, place: usize, values: &[f64]) -> PyResult<Py<PyAny>> {
        if let Some(array) = self.arrays[place].get() {
            return Ok(array.clone_ref(py));
        }
        let array = PyArray1::from_slice(py, values);
        array.call_method("setflags", (), Some(&[("write", false)].into_py_dict(py)?))?;
        // A view of what may not be written cannot be made writable.
        let array = array.call_method0("view")?.unbind();
        Ok(self.arrays[place].get_or_init(|| array).clone_ref(py))
    }
}

/// Arrays as the text of a motion's file.
fn csv(arrays: &[(&'static str, Vec<f64>)]) -> String {
    let columns = motion::OWN_COLUMNS.iter().filter_map(|(name, kind, ..)| {
        let (_, values) = arrays.iter().find(|(n, _)| n == name)?;
        Some((format!("{name} [{}]", kind.si), values))
    });
    let columns: Vec<(String, &Vec<f64>)> = columns.collect();
    let mut text = columns.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(",") + "\n";
    for k in 0..columns.first().map_or(0, |(_, values)| values.len()) {
        let row: Vec<String> = columns.iter().map(|(_, values)| values[k].to_string()).collect();
        text.push_str(&row.join(","));
        text.push('\n');
    }
    text
}

/// An array-like as numbers.
pub fn numbers(py: Python<'_>, name: &str, value: &Bound<PyAny>) -> PyResult<Vec<f64>> {
    let refused = |what: String| wrong(py, format!("`{name}` {what}"));
    let numpy = py.import("numpy")?;
    let options = PyDict::new(py);
    options.set_item("dtype", numpy.getattr("float64")?)?;
    // Of complex numbers and of texts it would make something.
    let given = numpy.call_method1("asarray", (value,)).map_err(|why| refused(format!("is no array: {why}")))?;
    let kind: String = given.getattr("dtype")?.getattr("kind")?.extract()?;
    if !"biuf".contains(&kind) && kind != "O" {
        return Err(refused("is no array of numbers".into()));
    }
    let masked = value.getattr("mask").and_then(|mask| mask.call_method0("any")).and_then(|any| any.is_truthy());
    if masked.unwrap_or(false) {
        return Err(refused("has masked entries: leave those samples out".into()));
    }
    let array = numpy
        .call_method("ascontiguousarray", (given,), Some(&options))
        .map_err(|why| refused(format!("is no array of numbers: {why}")))?;
    let dimensions: usize = array.getattr("ndim")?.extract()?;
    let scalar = value.getattr("ndim").and_then(|n| n.extract::<usize>()).map_or(value.len().is_err(), |n| n == 0);
    if dimensions != 1 || scalar {
        return Err(refused("has the wrong shape: expected one axis".into()));
    }
    let array: PyReadonlyArray1<f64> = array.extract().map_err(|_| refused("is no array of numbers".into()))?;
    Ok(array.as_slice().map_err(|_| refused("is not contiguous".into()))?.to_vec())
}

/// A quantity: a number is SI, a text has its unit.
pub fn quantity(
    py: Python<'_>,
    name: &str,
    value: &Bound<PyAny>,
    kind: &'static gearwise::units::Kind,
) -> PyResult<f64> {
    let refused = |what: String| wrong(py, format!("`{name}`: {what}"));
    if let Ok(text) = value.extract::<String>() {
        return gearwise::units::quantity(&text, kind)
            .map_err(|error| refused(format!("{}; {}", error.message(kind), error.help(kind))));
    }
    let number = value.extract::<f64>().map_err(|_| refused("expected a number or text with a unit".into()))?;
    if !number.is_finite() {
        return Err(refused(format!("{number} is no number")));
    }
    if kind.si == "K" && number < 200.0 {
        return Err(refused(format!("a bare number is in kelvin; did you mean \"{number} degC\"?")));
    }
    Ok(number)
}

fn optional(py: Python<'_>, name: &str, value: Option<&Bound<PyAny>>) -> PyResult<Option<Vec<f64>>> {
    value.filter(|value| !value.is_none()).map(|value| numbers(py, name, value)).transpose()
}

#[pymethods]
impl Motion {
    #[new]
    #[pyo3(signature = (time, torque, velocity=None, *, position=None, acceleration=None, periodic=true, period=None))]
    #[expect(clippy::too_many_arguments, reason = "as Python calls it")]
    fn new(
        py: Python<'_>,
        time: &Bound<'_, PyAny>,
        torque: &Bound<'_, PyAny>,
        velocity: Option<&Bound<'_, PyAny>>,
        position: Option<&Bound<'_, PyAny>>,
        acceleration: Option<&Bound<'_, PyAny>>,
        periodic: bool,
        period: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Motion> {
        let samples = Samples {
            time: numbers(py, "time", time)?,
            torque: numbers(py, "torque", torque)?,
            velocity: optional(py, "velocity", velocity)?,
            position: optional(py, "position", position)?,
            acceleration: optional(py, "acceleration", acceleration)?,
            torque_rate: None,
            jerk: None,
        };
        let period = period.filter(|p| !p.is_none());
        let period = period.map(|period| quantity(py, "period", period, &gearwise::units::TIME)).transpose()?;
        let arrays = [("time", Some(&samples.time)), ("torque", Some(&samples.torque))].into_iter();
        let more = [
            ("velocity", samples.velocity.as_ref()),
            ("position", samples.position.as_ref()),
            ("acceleration", samples.acceleration.as_ref()),
        ];
        let arrays = arrays.chain(more).filter_map(|(name, values)| Some((name, values?.clone()))).collect();
        let made = Made { kind: "samples", arrays, periodic, period, scale: (1.0, 1.0), file: None };
        let motion = here(py, || motion::of_arrays(samples, periodic, period).map_err(|e| vec![e].into()))?;
        Ok(Motion::of(Arc::new(motion), made))
    }

    #[staticmethod]
    #[pyo3(signature = (path, *, periodic=true, period=None))]
    fn read(
        py: Python<'_>,
        path: std::path::PathBuf,
        periodic: bool,
        period: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Motion> {
        let period = period.filter(|p| !p.is_none());
        let period = period.map(|period| quantity(py, "period", period, &gearwise::units::TIME)).transpose()?;
        let source = here(py, || Source::read(&path).map_err(|error| Failure::Input(vec![error])))?;
        let file = Some((source.name().to_string(), source.text().to_string()));
        let made = Made { kind: "file", arrays: Vec::new(), periodic, period, scale: (1.0, 1.0), file };
        Motion::again(py, made)
    }

    #[staticmethod]
    #[pyo3(signature = (torque, velocity, *, acceleration=None, duration=None))]
    fn points(
        py: Python<'_>,
        torque: &Bound<'_, PyAny>,
        velocity: &Bound<'_, PyAny>,
        acceleration: Option<&Bound<'_, PyAny>>,
        duration: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Motion> {
        let mut arrays =
            vec![("torque", numbers(py, "torque", torque)?), ("velocity", numbers(py, "velocity", velocity)?)];
        if let Some(acceleration) = optional(py, "acceleration", acceleration)? {
            arrays.push(("acceleration", acceleration));
        }
        if let Some(duration) = optional(py, "duration", duration)? {
            arrays.push(("duration", duration));
        }
        let made = Made { kind: "points", arrays, periodic: false, period: None, scale: (1.0, 1.0), file: None };
        Motion::again(py, made)
    }

    /// The same with all torques times one factor, played so many times as fast.
    #[pyo3(signature = (*, torque=1.0, speed=1.0))]
    fn scaled(&self, py: Python<'_>, torque: f64, speed: f64) -> PyResult<Motion> {
        for (name, factor) in [("torque", torque), ("speed", speed)] {
            if !(1e-6..=1e6).contains(&factor) {
                return Err(wrong(py, format!("`{name}` is {factor}: expected a factor between 1e-6 and 1e6")));
            }
        }
        let motion = motion::Motion::clone(&self.motion).scaled(torque, speed);
        let (before, fast) = self.made.scale;
        let made = Made { scale: (before * torque, fast * speed), ..self.made.clone() };
        Ok(Motion::of(Arc::new(motion), made))
    }

    #[getter]
    fn time(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.array(py, 0, &self.motion.time)
    }

    #[getter]
    fn torque(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.array(py, 1, &self.motion.torque)
    }

    #[getter]
    fn velocity(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.array(py, 2, &self.motion.velocity)
    }

    #[getter]
    fn acceleration(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.array(py, 3, &self.motion.acceleration)
    }

    #[getter]
    fn torque_rate(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.array(py, 4, &self.motion.torque_rate)
    }

    #[getter]
    fn jerk(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.array(py, 5, &self.motion.jerk)
    }

    #[getter]
    fn weight(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.array(py, 6, &self.motion.weight)
    }

    #[getter]
    fn derived(&self) -> Vec<&'static str> {
        self.motion.derived.clone()
    }

    #[getter]
    fn duration(&self) -> Option<f64> {
        self.motion.duration()
    }

    fn __len__(&self) -> usize {
        self.motion.len()
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<Motion>().is_ok_and(|other| other.get().id() == self.id())
    }

    fn __hash__(&self) -> u64 {
        u64::from_str_radix(self.id(), 16).unwrap_or_default()
    }

    fn __repr__(&self) -> String {
        let samples = self.motion.len();
        match self.motion.course {
            Course::Periodic(period) => format!("<Motion of {samples} samples, again every {period} s>"),
            Course::Once(duration) => format!("<Motion of {samples} samples, once, {duration} s>"),
            Course::Points(_) => format!("<Motion of {samples} operating points>"),
            Course::Cases => format!("<Motion of {samples} samples of several cases>"),
        }
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let made = &self.made;
        let arrays = PyDict::new(py);
        for (name, values) in &made.arrays {
            arrays.set_item(*name, PyArray1::from_slice(py, values))?;
        }
        let how = (made.periodic, made.period, made.scale);
        let state = (made.kind, arrays, how, made.file.clone()).into_pyobject(py)?;
        let again = py.get_type::<Motion>().getattr("_again")?;
        Ok((again, state.into_any()))
    }

    /// Made again from what `__reduce__` gave.
    #[staticmethod]
    #[pyo3(name = "_again")]
    fn unpickled(
        py: Python<'_>,
        kind: &str,
        arrays: &Bound<'_, PyDict>,
        how: (bool, Option<f64>, (f64, f64)),
        file: Option<(String, String)>,
    ) -> PyResult<Motion> {
        let (periodic, period, scale) = how;
        let names = ["time", "torque", "velocity", "position", "acceleration", "torque_rate", "jerk", "duration"];
        let kinds = ["samples", "file", "points", "episodes"];
        let Some(kind) = kinds.into_iter().find(|k| *k == kind) else {
            return Err(wrong(py, format!("a motion made of `{kind}` is of another version of gearwise")));
        };
        let mut found = Vec::new();
        for name in names {
            if let Some(values) = arrays.get_item(name)? {
                found.push((name, numbers(py, name, &values)?));
            }
        }
        Motion::again(py, Made { kind, arrays: found, periodic, period, scale, file })
    }
}

impl Motion {
    fn again(py: Python<'_>, made: Made) -> PyResult<Motion> {
        let take = |name: &str| made.arrays.iter().find(|(n, _)| *n == name).map(|(_, values)| values.clone());
        let needed = |name: &str| take(name).ok_or_else(|| wrong(py, format!("a motion needs `{name}`")));
        let motion = if let Some((name, text)) = &made.file {
            let source = Arc::new(Source::new(name.as_str(), text.as_str()));
            motion::read(&source, made.periodic, made.period).map_err(|e| raised(py, Failure::Input(vec![e])))?
        } else if ["points", "episodes"].contains(&made.kind) {
            let rates = (take("torque_rate"), take("jerk"));
            let (acceleration, duration) = (take("acceleration"), take("duration"));
            let points = of_points(py, needed("torque")?, needed("velocity")?, acceleration, duration, rates)?;
            motion::Motion { mixed: made.kind == "episodes", ..points }
        } else {
            let samples = Samples {
                time: needed("time")?,
                torque: needed("torque")?,
                velocity: take("velocity"),
                position: take("position"),
                acceleration: take("acceleration"),
                torque_rate: take("torque_rate"),
                jerk: take("jerk"),
            };
            let (periodic, period) = (made.periodic, made.period);
            motion::of_arrays(samples, periodic, period).map_err(|error| raised(py, Failure::Input(vec![error])))?
        };
        let motion = match made.scale {
            (1.0, 1.0) => motion,
            (torque, speed) => motion.scaled(torque, speed),
        };
        Ok(Motion::of(Arc::new(motion), made))
    }
}

fn of_points(
    py: Python<'_>,
    torque: Vec<f64>,
    velocity: Vec<f64>,
    acceleration: Option<Vec<f64>>,
    duration: Option<Vec<f64>>,
    (torque_rate, jerk): (Option<Vec<f64>>, Option<Vec<f64>>),
) -> PyResult<motion::Motion> {
    let count = torque.len();
    if count == 0 {
        return Err(wrong(py, "there is no operating point"));
    }
    let all = [
        ("torque", Some(&torque)),
        ("velocity", Some(&velocity)),
        ("acceleration", acceleration.as_ref()),
        ("duration", duration.as_ref()),
        ("torque_rate", torque_rate.as_ref()),
        ("jerk", jerk.as_ref()),
    ];
    for (name, values) in all.into_iter().filter_map(|(name, values)| Some((name, values?))) {
        if values.len() != count {
            return Err(wrong(py, format!("`{name}` has {} entries, and `torque` has {count}", values.len())));
        }
        if let Some(k) = values.iter().position(|v| !v.is_finite() || !gearwise::units::is_sane(*v)) {
            return Err(wrong(py, format!("`{name}`, point {k}: {} is no number of a motion", values[k])));
        }
    }
    if let Some(k) = duration.iter().flatten().position(|d| *d <= 0.0) {
        return Err(wrong(py, format!("`duration`, point {k}: is not greater than zero")));
    }
    let at = |values: &Option<Vec<f64>>, k: usize| values.as_ref().map_or(0.0, |v| v[k]);
    let point = |k: usize| Point {
        torque: torque[k],
        velocity: velocity[k],
        acceleration: at(&acceleration, k),
        torque_rate: at(&torque_rate, k),
        jerk: at(&jerk, k),
        duration: duration.as_ref().map(|d| d[k]),
    };
    Ok(motion::Motion::from_points(&(0..count).map(point).collect::<Vec<_>>()))
}

/// What a simulator's joint has of its own in place of an actuator's: armature, damping and friction, SI.
#[pyfunction]
pub fn _simulated(
    py: Python<'_>,
    armature: &Bound<'_, PyAny>,
    damping: &Bound<'_, PyAny>,
    friction: &Bound<'_, PyAny>,
) -> PyResult<(f64, f64, f64)> {
    use gearwise::units::{INERTIA, TORQUE, VISCOUS_FRICTION};
    let read = |name: &str, value: &Bound<'_, PyAny>, kind| {
        let number = quantity(py, name, value, kind)?;
        match number >= 0.0 {
            true => Ok(number),
            false => Err(wrong(py, format!("`{name}` is {number}: expected no number below zero"))),
        }
    };
    Ok((
        read("armature", armature, &INERTIA)?,
        read("damping", damping, &VISCOUS_FRICTION)?,
        read("friction", friction, &TORQUE)?,
    ))
}

/// Time, torque, velocity and, where it is known, acceleration of an episode.
type Episode<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>, Option<Bound<'py, PyAny>>);

/// A motion of many episodes.
#[pyfunction]
pub fn _rollouts<'py>(py: Python<'py>, episodes: Vec<Episode<'py>>, own: (f64, f64, f64)) -> PyResult<Motion> {
    let mut all = Vec::with_capacity(episodes.len());
    for (time, torque, velocity, acceleration) in &episodes {
        all.push(Samples {
            time: numbers(py, "time", time)?,
            torque: numbers(py, "torque", torque)?,
            velocity: Some(numbers(py, "velocity", velocity)?),
            position: None,
            acceleration: optional(py, "acceleration", acceleration.as_ref())?,
            torque_rate: None,
            jerk: None,
        });
    }
    let (armature, damping, friction) = own;
    let own = motion::SimulatorsOwn { armature, damping, friction };
    let motion = here(py, || motion::of_episodes(all, own).map_err(|e| vec![e].into()))?;
    let m = &motion;
    // Made again from its samples: each has all of its rates.
    let total = motion.duration().unwrap_or(1.0);
    let durations = m.weight.iter().map(|weight| weight * total).collect();
    let column = |name, values: &Vec<f64>| (name, values.clone());
    let made = Made {
        kind: "episodes",
        arrays: vec![
            column("torque", &m.torque),
            column("velocity", &m.velocity),
            column("acceleration", &m.acceleration),
            column("torque_rate", &m.torque_rate),
            column("jerk", &m.jerk),
            ("duration", durations),
        ],
        periodic: false,
        period: None,
        scale: (1.0, 1.0),
        file: None,
    };
    Ok(Motion::of(Arc::new(motion), made))
}
