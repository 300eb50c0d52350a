use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;

use super::{Done, Failure};
use crate::catalog::add::{Of, Target, added, has, rows};
use crate::catalog::audit::{Finding, Severity, audit};
use crate::catalog::{Catalog, is_word, user_catalog};
use crate::input::Source;
use crate::output::{self, Locks};
pub use crate::report::counted;

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(
    before_help = "Examples:\n  gearwise catalog add my_motor.csv\n  gearwise catalog add my_motor.csv --to my_catalog.csv\n\n\
                   Rows are read as any catalogue is, and audited: a row that contradicts itself is not added unless it accepts the finding with a note. \
                   What is now in the file stays as it is; rows come behind it, and columns that it lacks. An id that is there already is refused."
)]
pub struct Arguments {
    /// Files with rows, CSV or TOML
    #[arg(value_name = "ROW", required = true)]
    from: Vec<PathBuf>,
    /// The catalogue file; without it one's own catalogue (`gearwise catalog path`)
    #[arg(long, value_name = "FILE")]
    to: Option<PathBuf>,
}

pub fn run(arguments: &Arguments) -> Result<Done, Failure> {
    let (mut sources, mut errors) = (Vec::new(), Vec::new());
    for path in &arguments.from {
        match Source::read(path) {
            Ok(source) => sources.push(source),
            Err(error) => errors.push(error),
        }
    }
    if !errors.is_empty() {
        return Err(errors.into());
    }
    let new = rows(&sources)?;
    check(&new)?;
    // What cannot be added is said, whatever else there is.
    for source in &sources {
        crate::catalog::add::can_be_added(source).map_err(|error| vec![error])?;
    }
    // From here to where they are written nobody else changes the files: what is added meanwhile would be lost.
    let mut locks = Locks::default();
    if arguments.to.is_none() {
        let user = user_catalog();
        folder_of(&user).map_or(Ok(()), output::make_folder).map_err(Failure::Argument)?;
        locks.take(&user).map_err(Failure::Argument)?;
    }
    let mut changes = Vec::new();
    for of in Of::ALL {
        let holds = |source: &&Arc<Source>| has(source, of).unwrap_or(false);
        let from: Vec<Arc<Source>> = sources.iter().filter(holds).cloned().collect();
        if from.is_empty() {
            continue;
        }
        let path = arguments.to.clone().map_or_else(|| own(of), Ok)?;
        // In a folder that is not there yet nobody else has one.
        if arguments.to.is_some() || folder_of(&path).is_none_or(Path::is_dir) {
            locks.take(&path).map_err(Failure::Argument)?;
        }
        if arguments.to.is_some() {
            check_target(&path, of)?;
        } else {
            check_beside(&path, &sources)?;
        }
        let there = if path.exists() { Some(Source::read(&path).map_err(|e| vec![e])?) } else { None };
        let target = Target { name: path.display().to_string(), there };
        let (text, ids) = added(&target, &from, of)?;
        changes.push((path, text, ids));
    }
    let twice = changes.windows(2).find(|pair| pair[0].0 == pair[1].0);
    if let Some([(first, ..), _]) = twice {
        let why =
            format!("`{}` is one file, which holds motors, gears or modules; add them to a file each", first.display());
        return Err(Failure::Argument(why));
    }
    let mut said = String::new();
    for (path, text, ids) in &changes {
        if let Some(folder) = folder_of(path).filter(|_| arguments.to.is_none()) {
            output::make_folder(folder).map_err(Failure::Argument)?;
        }
        output::write_over(path, text.as_bytes()).map_err(Failure::Argument)?;
        said.push_str(&format!("{}: {} added: {}\n", path.display(), counted(ids.len(), "row"), ids.join(", ")));
    }
    warn(&changes)?;
    Ok(Done { text: said, satisfied: true })
}

/// The folder that a path names.
fn folder_of(path: &Path) -> Option<&Path> {
    path.parent().filter(|folder| !folder.as_os_str().is_empty())
}

/// A row that contradicts itself is refused.
fn check(new: &Catalog) -> Result<(), Failure> {
    let findings = audit(new);
    let wrong: Vec<&Finding> = findings.iter().filter(|f| f.severity == Severity::Error && !f.accepted).collect();
    let Some(first) = wrong.first() else { return Ok(()) };
    let why = first.explanation.as_ref().map_or_else(String::new, |why| format!(" ({why})"));
    let more = if wrong.len() > 1 { format!(", and {} more", wrong.len() - 1) } else { String::new() };
    Err(Failure::Argument(format!(
        "nothing is added: `{}` contradicts itself, [{}] {}{why}{more}; correct the row, or accept the finding in its columns `audit_accept` and `note`",
        first.id, first.code, first.message
    )))
}

/// One's own catalogue: a file, or a folder with a file for each kind.
fn own(of: Of) -> Result<PathBuf, Failure> {
    let user = user_catalog();
    let is_file = user.is_file() || !user.exists() && user.extension().is_some_and(|e| e.eq_ignore_ascii_case("csv"));
    Ok(match (is_file, of) {
        (true, _) => user,
        (false, of) => user.join(of.word()).join("mine.csv"),
    })
}

/// A file that one names must be one that rows can be put into.
fn check_target(path: &Path, of: Of) -> Result<(), Failure> {
    let shown = path.display();
    if is_word(&path.to_string_lossy()) {
        let why = format!("`--to {shown}` is a word, not a file; without `--to` rows go into `user`");
        return Err(Failure::Argument(why));
    }
    if path.is_dir() {
        return Err(Failure::Argument(format!("`--to {shown}` is a folder; name a file in it")));
    }
    if !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("csv")) {
        return Err(Failure::Argument(format!("`--to {shown}` is no .csv file: rows are put into tables")));
    }
    if path.exists() {
        let source = Source::read(path).map_err(|e| vec![e])?;
        for other in Of::ALL.into_iter().filter(|other| *other != of) {
            if has(&source, other).map_err(|e| vec![e])? {
                let (new, there) = (of.word(), other.word());
                let why = format!("`{shown}` holds {there}; {new} need a file of their own");
                return Err(Failure::Argument(why));
            }
        }
    }
    Ok(())
}

/// No id may be in another file of one's own catalogue.
fn check_beside(path: &Path, from: &[Arc<Source>]) -> Result<(), Failure> {
    let user = user_catalog();
    if !user.is_dir() || path == user {
        return Ok(());
    }
    // A folder without a file yet is no mistake here.
    let beside = match Catalog::sources(std::slice::from_ref(&user)) {
        Ok(sources) => sources,
        Err((sources, _)) => sources,
    };
    let own = path.display().to_string();
    let others: Vec<Arc<Source>> = beside.into_iter().filter(|s| s.name() != own).collect();
    Catalog::from_sources(others.iter().chain(from).cloned().collect()).map(|_| ()).map_err(Failure::Input)
}

/// Ids that are in the built-in catalogue too: the two cannot be read together.
fn warn(changes: &[(PathBuf, String, Vec<String>)]) -> Result<(), Failure> {
    let builtin = Catalog::builtin()?;
    let is_builtin = |id: &&String| {
        let of_modules = builtin.modules.iter().any(|m| m.id == **id);
        of_modules || builtin.motors.iter().any(|m| m.id == **id) || builtin.gears.iter().any(|g| g.id == **id)
    };
    for (path, _, ids) in changes {
        let both: Vec<&str> = ids.iter().filter(is_builtin).map(String::as_str).collect();
        if !both.is_empty() {
            tell!(
                "warning: in the built-in catalogue too: {}; `--also {}` will refuse the two together",
                both.join(", "),
                path.display()
            );
        }
    }
    Ok(())
}
