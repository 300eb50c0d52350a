//! The list of work: which requirement files a study reads, in which order.
//!
//! The one idea: the list is never held. Folders and patterns are walked in the order of their names, one
//! folder's names at a time, and each file is handed on as it is found; the journal keeps the list on disk.

use std::fs;
use std::path::{Path, PathBuf};

use fast_glob::glob_match;

use super::StudyError;
use crate::words::nearest;

/// Folders are searched this deep below `**`: deeper is a loop of links.
const DEEPEST: usize = 64;

/// A part of a pattern between two slashes.
enum Part {
    Plain(String),
    Pattern(String, bool),
    AnyDepth,
}

/// Hands on every requirement file that `paths` name (files, folders with `.toml` files, patterns), by the
/// name it has for people. Names are relative to `base`.
///
/// # Errors
/// A path that is not there, a folder or a pattern without a `.toml` file, and what `found` says.
pub fn walk(
    base: &Path,
    paths: &[String],
    found: &mut dyn FnMut(&str) -> Result<(), StudyError>,
) -> Result<(), StudyError> {
    for path in paths {
        let mut count = 0_u64;
        let mut counted = |name: &str| {
            count += 1;
            found(name)
        };
        let place = base.join(path);
        let is_pattern = path.contains(['*', '?', '[', '{']) && !place.exists();
        if is_pattern {
            let (root, parts) = parts(path)?;
            descend(base, &root, &parts, 0, &mut counted)?;
            if count == 0 {
                return Err(StudyError::Argument(format!(
                    "no file matches `{}`{}",
                    crate::words::shorten(path),
                    why_nothing(base, &root, &parts)
                )));
            }
        } else if place.is_dir() {
            for name in names(&place)? {
                let file = Path::new(path).join(&name);
                if name.to_lowercase().ends_with(".toml") && base.join(&file).is_file() {
                    counted(&shown(&file)?)?;
                }
            }
            if count == 0 {
                let message = format!("there is no .toml file in the folder `{path}`; `{path}/**/*.toml` looks deeper");
                return Err(StudyError::Argument(message));
            }
        } else if place.is_file() {
            counted(path)?;
        } else {
            let folder = place.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
            let wanted = place.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
            let near =
                names(folder).ok().and_then(|n| nearest(&wanted, n.iter().map(String::as_str)).map(String::from));
            let help = near.map_or_else(String::new, |n| format!("; there is `{n}` in that folder"));
            return Err(StudyError::Argument(format!("there is no file or folder `{path}`{help}")));
        }
    }
    Ok(())
}

/// The plain start of a pattern, and its parts after that.
fn parts(pattern: &str) -> Result<(PathBuf, Vec<Part>), StudyError> {
    let mut root = PathBuf::from(if pattern.starts_with('/') { "/" } else { "" });
    let mut parts = Vec::new();
    for text in pattern.split('/').filter(|t| !t.is_empty()) {
        let part = match text {
            "**" => Part::AnyDepth,
            text if text.contains(['*', '?', '[', '{']) => {
                for (open, close) in [('[', ']'), ('{', '}')] {
                    if text.matches(open).count() > text.matches(close).count() {
                        let message = format!("`{pattern}` is not a pattern: `{open}` without `{close}`");
                        return Err(StudyError::Argument(message));
                    }
                }
                Part::Pattern(text.into(), text.starts_with('.'))
            }
            text if parts.is_empty() => {
                root.push(text);
                continue;
            }
            text => Part::Plain(text.into()),
        };
        parts.push(part);
    }
    Ok((root, parts))
}

fn descend(
    base: &Path,
    at: &Path,
    parts: &[Part],
    depth: usize,
    found: &mut dyn FnMut(&str) -> Result<(), StudyError>,
) -> Result<(), StudyError> {
    let place = base.join(at);
    let Some((part, rest)) = parts.split_first() else {
        return if place.is_file() { found(&shown(at)?) } else { Ok(()) };
    };
    match part {
        Part::Plain(name) => descend(base, &at.join(name), rest, depth, found),
        Part::Pattern(pattern, hidden) => {
            if !place.is_dir() && !at.as_os_str().is_empty() {
                return Ok(());
            }
            for name in names(&place)? {
                if glob_match(pattern, &name) && (*hidden || !name.starts_with('.')) {
                    descend(base, &at.join(&name), rest, depth, found)?;
                }
            }
            Ok(())
        }
        Part::AnyDepth => {
            // A pattern that ends in `**` means the .toml files below.
            if rest.is_empty() {
                return descend(base, at, &[Part::AnyDepth, Part::Pattern("*.toml".into(), false)], depth, found);
            }
            descend(base, at, rest, depth, found)?;
            if depth >= DEEPEST || (!place.is_dir() && !at.as_os_str().is_empty()) {
                return Ok(());
            }
            for name in names(&place)? {
                let inner = at.join(&name);
                if !name.starts_with('.') && base.join(&inner).is_dir() {
                    descend(base, &inner, parts, depth + 1, found)?;
                }
            }
            Ok(())
        }
    }
}

/// What a pattern that matches nothing could have meant: the names beside it.
fn why_nothing(base: &Path, root: &Path, parts: &[Part]) -> String {
    let place = base.join(root);
    let place = if place.as_os_str().is_empty() { PathBuf::from(".") } else { place };
    if !place.is_dir() {
        return format!("; there is no folder `{}`", root.display());
    }
    let Ok(names) = names(&place) else { return String::new() };
    if names.is_empty() || parts.is_empty() {
        return format!("; the folder `{}` is empty", root.display());
    }
    let shown: Vec<&str> = names.iter().map(String::as_str).take(5).collect();
    let more = if names.len() > shown.len() { ", …" } else { "" };
    format!("; `{}` has {}{more}", place.display(), shown.join(", "))
}

/// The names in a folder, in order.
fn names(folder: &Path) -> Result<Vec<String>, StudyError> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let fail = |e: std::io::Error| StudyError::file("read the folder", folder, &e);
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).map_err(fail)? {
        // A name that is not UTF-8 cannot stand in the results.
        if let Ok(name) = entry.map_err(fail)?.file_name().into_string() {
            names.push(name);
        }
    }
    names.sort_unstable();
    Ok(names)
}

/// A path as it stands in lists and results.
fn shown(path: &Path) -> Result<String, StudyError> {
    match path.to_str() {
        Some(text) if !text.contains(['\n', '\r']) => Ok(text.to_string()),
        _ => {
            Err(StudyError::Argument(format!("the file name {path:?} cannot be in a list: it is not one line of text")))
        }
    }
}
