//! Requirements: what a robot asks for, from words, tables or files.

use std::collections::HashMap;
use std::hash::{Hash, Hasher};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use gearwise::ask::Failure;
use gearwise::input::Source;
use gearwise::motion::{self, CarriedColumn};
use gearwise::requirement::saved::{self, Kept};
use gearwise::requirement::{Motions, Robot, Settings};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

use crate::failure::wrong;
use crate::motion::{Motion, Written};
use crate::pool::here;
use crate::values::Writer;

/// What messages call values that were handed over.
const NAME: &str = "the requirement";

/// A requirement, checked and immutable.
#[pyclass(frozen, module = "gearwise._native")]
pub struct Requirement {
    source: Arc<Source>,
    /// Changes in the order in which they were made: keys, and values as TOML.
    changes: Vec<(String, String)>,
    motions: Arc<HashMap<String, Py<Motion>>>,
    robot: Arc<Robot>,
}

/// The name of a file, and what is changed in it.
type Changed = (String, Vec<(String, String)>);

/// Motions that are handed over, and files beside the requirement.
struct Store(HashMap<String, Arc<motion::Motion>>);

impl Motions for Store {
    fn given(&mut self, name: &str) -> Option<(Arc<motion::Motion>, Vec<CarriedColumn>)> {
        self.0.get(name).map(|motion| (motion.clone(), Vec::new()))
    }
}

impl Requirement {
    /// The robot that it describes.
    pub fn robot(&self) -> Arc<Robot> {
        self.robot.clone()
    }

    /// What it was read from.
    pub fn source(&self) -> Arc<Source> {
        self.source.clone()
    }

    /// The robot for what cannot choose a spring; `what` says who cannot.
    pub fn without_springs(&self, py: Python<'_>, what: &str) -> PyResult<Arc<Robot>> {
        if self.robot.joints.iter().all(|joint| joint.limits.spring.is_none()) {
            return Ok(self.robot.clone());
        }
        read(py, &self.source, &self.changes, &self.motions, Some(what)).map(Arc::new)
    }

    fn read(
        py: Python<'_>,
        source: Arc<Source>,
        changes: Vec<(String, String)>,
        motions: HashMap<String, Py<Motion>>,
    ) -> PyResult<Requirement> {
        let robot = read(py, &source, &changes, &motions, None)?;
        Ok(Requirement { source, changes, motions: Arc::new(motions), robot: Arc::new(robot) })
    }
}

impl Requirement {
    /// Writes files, the requirement last, and reads that again.
    fn written(&self, files: &[(PathBuf, String)]) -> Result<(), Failure> {
        let Some((path, _)) = files.last() else { return Ok(()) };
        for (path, text) in files {
            std::fs::write(path, text).map_err(|why| {
                let why = gearwise::words::reason(&why);
                Failure::Argument(format!("cannot write `{}`: {why}", path.display()))
            })?;
        }
        let source = Source::read(path).map_err(|error| vec![error])?;
        Settings::default().read(&source, None)?;
        Ok(())
    }

    /// That the files it names are next to a place, too.
    fn names_files_of(&self, folder: &Path) -> Result<(), Failure> {
        let own = self.source.name();
        let Some(named) = self.robot.files().into_iter().find(|file| file.name != own) else { return Ok(()) };
        let here = |path: &Path| if path.as_os_str().is_empty() { PathBuf::from(".") } else { path.to_path_buf() };
        let [from, to] = [self.source.folder(), folder].map(|path| here(path).canonicalize());
        match (from, to) {
            (Ok(from), Ok(to)) if from == to => Ok(()),
            _ => Err(Failure::Argument(format!(
                "the requirement names `{}`, which is looked for next to it: save it in `{}`",
                named.name,
                here(self.source.folder()).display()
            ))),
        }
    }
}

fn store(motions: &HashMap<String, Py<Motion>>) -> Store {
    Store(motions.iter().map(|(name, motion)| (name.clone(), motion.get().shared())).collect())
}

fn read(
    py: Python<'_>,
    source: &Arc<Source>,
    changes: &[(String, String)],
    motions: &HashMap<String, Py<Motion>>,
    no_springs: Option<&str>,
) -> PyResult<Robot> {
    let mut store = store(motions);
    let values = changes.iter().map(|(key, value)| (key.as_str(), value.clone()));
    let settings = Settings::of_values("the changes", values).map_err(|why| wrong(py, why))?;
    here(py, || settings.read_with(source, no_springs, &mut store).map_err(Failure::Input))
}

/// A requirement of whatever a call was given: one that is read, a file, words or a table.
pub fn taken<'py>(py: Python<'py>, value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, Requirement>> {
    match value.cast::<Requirement>() {
        Ok(requirement) => Ok(requirement.clone()),
        Err(_) => Bound::new(py, Requirement::new(py, value, None)?),
    }
}

#[pymethods]
impl Requirement {
    #[new]
    #[pyo3(signature = (source, *, motions=None))]
    fn new(py: Python<'_>, source: &Bound<'_, PyAny>, motions: Option<&Bound<'_, PyDict>>) -> PyResult<Requirement> {
        let mut known = HashMap::new();
        for (name, motion) in motions.into_iter().flatten() {
            let name: String = name.extract().map_err(|_| wrong(py, "`motions`: a name is no text"))?;
            let motion = motion.cast::<Motion>().map_err(|_| wrong(py, format!("`motions`: `{name}` is no Motion")))?;
            known.insert(name, motion.clone().unbind());
        }
        if let Ok(other) = source.cast::<Requirement>() {
            let other = other.get();
            let both = other.motions.iter().map(|(name, motion)| (name.clone(), motion.clone_ref(py))).chain(known);
            return Requirement::read(py, other.source.clone(), other.changes.clone(), both.collect());
        }
        if source.is_instance_of::<PyString>() || source.hasattr("__fspath__")? {
            let path: std::path::PathBuf =
                source.extract().map_err(|_| wrong(py, "the requirement's path is no text"))?;
            let source = here(py, || Source::read(&path).map_err(|error| Failure::Input(vec![error])))?;
            return Requirement::read(py, source, Vec::new(), known);
        }
        let mut writer = Writer::new(py);
        let text = writer.file(source)?;
        known.extend(writer.motions);
        Requirement::read(py, Arc::new(Source::of_values(NAME, text)), Vec::new(), known)
    }

    /// The same with other values: keys as in `--set`.
    fn replace(&self, py: Python<'_>, changes: &Bound<'_, PyAny>) -> PyResult<Requirement> {
        let mut writer = Writer::new(py);
        let mut made = self.changes.clone();
        let items = changes.cast::<pyo3::types::PyMapping>().map_err(|_| wrong(py, "the changes are no mapping"))?;
        for item in items.items()?.iter() {
            let (key, value): (Bound<PyAny>, Bound<PyAny>) = item.extract()?;
            let key: String = key.extract().map_err(|_| wrong(py, "a key of the changes is no text"))?;
            let Some(value) = writer.value(&value, &key, 0)? else {
                return Err(wrong(py, format!("`{key}`: None is no value; leave it out to keep what is there")));
            };
            made.retain(|(known, _)| *known != key);
            made.push((key, value.to_string()));
        }
        let motions = self.motions.iter().map(|(name, motion)| (name.clone(), motion.clone_ref(py)));
        Requirement::read(py, self.source.clone(), made, motions.chain(writer.motions).collect())
    }

    /// As a TOML file: numbers with their units, comments kept. Motions that were handed over keep the names that stand for
    /// them.
    fn to_toml(&self, py: Python<'_>) -> PyResult<String> {
        let values = self.changes.iter().map(|(key, value)| (key.as_str(), value.clone()));
        let settings = Settings::of_values("the changes", values).map_err(|why| wrong(py, why))?;
        let mut store = store(&self.motions);
        here(py, || Ok(settings.to_toml(&self.source, &mut store)))
    }

    /// Writes it as a TOML file, with the motions that it was given in CSV files next to it, named after their joints. Gives the paths
    /// of all files. It is read back: the saved file answers as this does.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<Vec<PathBuf>> {
        let text = self.to_toml(py)?;
        let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
        let stem = stem.ok_or_else(|| wrong(py, format!("`{}` is no name of a file", path.display())))?;
        let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
        here(py, || self.names_files_of(&folder))?;
        let (mut files, mut kept) = (Vec::<(PathBuf, String)>::new(), HashMap::new());
        for (name, who) in saved::users(&text) {
            let Some(motion) = self.motions.get(&name) else { continue };
            let Some((written, factors)) = motion.get().written() else {
                let why = format!(
                    "`{who}`: no file holds a motion of episodes: keep the episodes, or pickle the requirement"
                );
                return Err(wrong(py, why));
            };
            let place = match written {
                Written::Points(points) => Kept::Points(points),
                Written::File(text, periodic, period) => {
                    let clean = |c: char| if c.is_alphanumeric() || "-_".contains(c) { c } else { '_' };
                    // Long names are cut, and case tells no files apart on some disks.
                    let own: String = format!("{stem}-{who}").chars().map(clean).take(60).collect();
                    let is = |path: &Path, name: &str| {
                        path.file_name()
                            .is_some_and(|known| known.to_string_lossy().to_lowercase() == name.to_lowercase())
                    };
                    let free = |name: &String| files.iter().all(|(path, _)| !is(path, name));
                    let names = (1..).map(|n| if n == 1 { format!("{own}.csv") } else { format!("{own}-{n}.csv") });
                    let name = names.into_iter().find(free).unwrap_or_default();
                    files.push((folder.join(&name), text));
                    Kept::File { name, periodic, period }
                }
            };
            kept.insert(name, (place, factors));
        }
        files.push((path, saved::with_motions(&text, &kept)));
        here(py, || self.written(&files))?;
        Ok(files.into_iter().map(|(path, _)| path).collect())
    }

    /// The file that it was read from, with the changes made since; None where Python made something of it. Refused where the
    /// file, or one that it names, is another by now.
    #[pyo3(name = "_file")]
    fn file(&self, py: Python<'_>) -> PyResult<Option<Changed>> {
        if self.source.is_of_values() || !self.motions.is_empty() {
            return Ok(None);
        }
        here(py, || {
            let own = [self.source.file()];
            for file in own.iter().chain(&self.robot.files()) {
                let now = Source::read(Path::new(&file.name)).map_err(|error| vec![error])?;
                if now.sha256() != file.sha256 {
                    let why = format!("`{}` has changed since the requirement was read: read it again", file.name);
                    return Err(Failure::Argument(why));
                }
            }
            Ok(Some((self.source.name().to_string(), self.changes.clone())))
        })
    }

    #[getter]
    fn name(&self) -> &str {
        &self.robot.name
    }

    #[getter]
    fn joints(&self) -> Vec<String> {
        self.robot.joints.iter().map(|joint| joint.name.clone()).collect()
    }

    /// The motions that it was given, by the names that stand for them.
    #[getter]
    fn motions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for (name, motion) in self.motions.iter() {
            dict.set_item(name, motion)?;
        }
        Ok(dict)
    }

    fn __repr__(&self) -> String {
        let joints = self.joints().join(", ");
        format!("<Requirement {}: {joints}>", self.robot.name)
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<Requirement>().is_ok_and(|other| {
            let other = other.get();
            let same = |(name, motion): (&String, &Py<Motion>)| {
                other.motions.get(name).is_some_and(|theirs| theirs.get().id() == motion.get().id())
            };
            self.source.text() == other.source.text()
                && self.changes == other.changes
                && self.motions.len() == other.motions.len()
                && self.motions.iter().all(same)
        })
    }

    fn __hash__(&self) -> u64 {
        let mut hash = std::hash::DefaultHasher::new();
        (self.source.text(), &self.changes).hash(&mut hash);
        hash.finish()
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let again = py.get_type::<Requirement>().getattr("_again")?;
        let state = (
            env!("CARGO_PKG_VERSION"),
            self.source.name(),
            self.source.text(),
            self.source.is_of_values(),
            self.changes.clone(),
            self.motions(py)?,
        );
        Ok((again, state.into_pyobject(py)?.into_any()))
    }

    /// Made again from what `__reduce__` gave.
    #[staticmethod]
    #[pyo3(name = "_again")]
    fn again(
        py: Python<'_>,
        version: &str,
        name: &str,
        text: &str,
        of_values: bool,
        changes: Vec<(String, String)>,
        motions: &Bound<'_, PyDict>,
    ) -> PyResult<Requirement> {
        same_version(py, "requirement", version)?;
        let source = if of_values { Source::of_values(name, text) } else { Source::new(name, text) };
        let mut known = HashMap::new();
        for (name, motion) in motions {
            known.insert(name.extract()?, motion.cast::<Motion>()?.clone().unbind());
        }
        Requirement::read(py, Arc::new(source), changes, known)
    }
}

/// That something was pickled by this version.
pub fn same_version(py: Python<'_>, what: &str, version: &str) -> PyResult<()> {
    let own = env!("CARGO_PKG_VERSION");
    match version == own {
        true => Ok(()),
        false => Err(wrong(py, format!("this {what} was pickled by gearwise {version}, and this is {own}"))),
    }
}
