//! What a check found, for people and for machines: one file for each form, all from the same
//! [`Report`](crate::rules::Report).

pub mod github;
pub mod input;
pub mod junit;
pub mod sarif;
pub mod text;

use std::path::Path;

use crate::actuator::limits::LIMITS;
use crate::rules::clean;
use crate::rules::measure::measure;

/// A file as tools that know the repository call it: relative to `root` (the folder the program runs in) where it
/// lies below, with forward slashes; else as it is.
pub fn relative(file: &str, root: &Path) -> String {
    let file = clean(file);
    let root = clean(&root.display().to_string());
    match file.strip_prefix(&format!("{}/", root.trim_end_matches('/'))) {
        Some(rest) => rest.to_string(),
        None => file,
    }
}

/// The SI unit of a finding's numbers, by its subject; `1` for a pure number.
pub(in crate::report) fn unit_of(subject: &str) -> &'static str {
    let limit = LIMITS.iter().find(|l| l.name == subject).map(|l| l.unit);
    let measured = || measure(subject).map(|m| m.kind.map_or(m.unit, |kind| kind.si));
    limit.or_else(measured).unwrap_or("1")
}
