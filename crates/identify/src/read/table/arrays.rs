//! A log of arrays, one for each column: Parquet, `.npz`, MCAP.

use std::fs::File;
use std::io::Seek;
use std::path::Path;
use std::sync::Arc;

use super::gather::Gather;
use super::record::{Mistakes, Record, Series, short};
use super::wanted::{Rows, Wanted, hash_of, shared};
use crate::read::columns::Target;
use crate::read::remark::Remark;
use gearwise_model::input::{InputError, Opened, Problem, Source, hex, limits};

/// Which columns of a file a log needs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Asked<'a> {
    /// All of them, each once, in the order of the alphabet.
    pub names: Vec<&'a str>,
    /// That of time.
    pub time: Option<&'a str>,
}

impl<'a> Asked<'a> {
    fn of(wanted: &'a Wanted) -> Asked<'a> {
        let selected = wanted.select.iter().map(|c| c.column.as_str());
        let mut names: Vec<&str> = wanted.columns.iter().map(|c| c.name.as_str()).chain(selected).collect();
        names.sort_unstable();
        names.dedup();
        let time = wanted.columns.iter().find(|c| c.target == Target::Time).map(|c| c.name.as_str());
        Asked { names, time }
    }
}

/// What a file has.
#[derive(Debug, Default)]
pub struct Loaded {
    /// The names of its columns.
    pub header: Vec<String>,
    /// The values of those that were asked for, all of one length.
    pub series: Vec<Option<Series>>,
    /// How many rows there are.
    pub rows: usize,
    /// Columns that have the latest value of another topic, each with the age of the oldest one \[ns\].
    pub latest: Vec<(usize, u64)>,
}

/// Reads the columns that are asked for, of an open file that stands at its beginning.
///
/// # Errors
/// All that is wrong with the file, or with those columns.
pub type Reader = fn(&File, &Asked) -> Result<Loaded, Vec<Problem>>;

/// A column that is there and cannot be read as numbers.
pub fn unusable(column: &str, what: impl std::fmt::Display, help: impl Into<String>) -> Problem {
    Problem::whole(format!("column `{column}`: {what}")).help(help)
}

/// That so many numbers are more than can be taken.
pub fn too_large(what: &str, numbers: impl std::fmt::Display, most: usize) -> Problem {
    Problem::whole(limits::too_many(what, numbers, most))
        .help("keep every n-th row, or cut the recording into several files")
}

/// Reads the logs of one file.
///
/// # Errors
/// What is wrong with the log file.
pub fn read(
    (path, name): (&Path, &str),
    mut opened: Opened,
    reader: Reader,
    wanted: &[Wanted],
    note: &mut dyn FnMut(Problem),
) -> Result<Option<(String, Vec<Rows>)>, InputError> {
    let wrong = |problems: Vec<Problem>| InputError { source: Arc::new(Source::new(name, "")), problems };
    let cannot = |e: std::io::Error| {
        wrong(vec![Problem::whole(format!("cannot read the file: {}", gearwise_model::words::reason(&e)))])
    };
    let hash = hash_of(&mut opened.file).map_err(cannot)?;
    let mut mistakes = Mistakes::new(path);
    let mut logs: Vec<Option<Gather>> = Vec::new();
    // Of each row, whether a log to fit and one that judges have it.
    let mut uses: Vec<[bool; 2]> = Vec::new();
    let mut latest: Vec<Vec<Remark>> = Vec::new();
    let mut last: Option<(Asked, Loaded)> = None;
    for wanted in wanted {
        let asked = Asked::of(wanted);
        if last.as_ref().is_none_or(|(before, _)| *before != asked) {
            opened.file.rewind().map_err(cannot)?;
            last = Some((asked.clone(), reader(&opened.file, &asked).map_err(wrong)?));
        }
        let Some((_, loaded)) = &last else { continue };
        if loaded.rows == 0 {
            return Err(wrong(vec![Problem::whole("the file has no rows")]));
        }
        for column in &wanted.columns {
            let at = loaded.header.iter().position(|name| *name == column.name);
            match at.and_then(|at| loaded.series[at].as_ref()) {
                Some(Series::Texts(texts)) => {
                    let what = format!("it holds texts, not numbers: `{}`, …", short(texts[0].as_bytes()));
                    mistakes.note(unusable(&column.name, what, "a text can only `select` rows"));
                }
                Some(Series::Stamps(_)) if column.target != Target::Time => {
                    let what = "it holds the times of its messages";
                    mistakes.note(unusable(&column.name, what, "only the column `time` can be such"));
                }
                Some(Series::Stamps(_)) if column.gain != 1.0 => note(
                    Problem::at(
                        column.span.clone(),
                        format!("`{}` counts in seconds", column.name),
                        "has another unit",
                    )
                    .help("unit = \"s\", without `sign` and `scale`: stamps count from the first one of the log"),
                ),
                _ => {}
            }
        }
        let record = |row| Record::Values { row, series: &loaded.series };
        let mut log = Gather::new(wanted, &loaded.header, record(0), name, &mut mistakes, note);
        if let Some(log) = log.as_mut().filter(|_| mistakes.problems.is_empty()) {
            uses.resize(uses.len().max(loaded.rows), [false; 2]);
            for (row, used) in uses.iter_mut().enumerate().take(loaded.rows) {
                if log.selects(record(row), &mut mistakes) {
                    used[usize::from(wanted.held_out)] = true;
                    log.take(record(row), &mut mistakes);
                }
                if mistakes.are_enough() {
                    break;
                }
            }
        }
        let stale = |(at, oldest): &(usize, u64)| {
            let column = wanted.columns.iter().find(|c| c.name == loaded.header[*at])?;
            Some(Remark::Latest { key: column.key, microseconds: oldest.div_ceil(1000) })
        };
        latest.push(loaded.latest.iter().filter_map(stale).collect());
        logs.push(log);
    }
    opened.unchanged(|file| Ok(hash_of(file)? == hash)).map_err(|p| wrong(vec![p]))?;
    if !mistakes.problems.is_empty() {
        return Err(mistakes.into_error(name));
    }
    let Some(logs) = logs.into_iter().collect::<Option<Vec<Gather>>>() else { return Ok(None) };
    let both = uses.iter().filter(|used| **used == [true; 2]).count();
    if both > 0 {
        note(shared(wanted, both, name));
        return Ok(None);
    }
    let finished = logs.into_iter().zip(latest).map(|(log, mut latest)| {
        let mut rows = log.finish(name, note)?;
        latest.append(&mut rows.remarks);
        Some(Rows { remarks: latest, ..rows })
    });
    let rows: Vec<Option<Rows>> = finished.collect();
    Ok(rows.into_iter().collect::<Option<Vec<Rows>>>().map(|rows| (hex(&hash), rows)))
}
