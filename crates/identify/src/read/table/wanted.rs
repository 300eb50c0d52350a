//! What a log wants of its file, what it gets, and what all formats say alike.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read};
use std::ops::Range as Span;

use hmac_sha256::Hash as Sha256;

use crate::bench::Channel;
use crate::read::columns::Column;
use crate::read::remark::Remark;
use gearwise_model::input::{Problem, limits};

/// What the cells of a column must be for a row to belong to a log.
#[derive(Debug, Clone)]
pub struct Condition {
    /// Its name in the header.
    pub column: String,
    /// Where the bench file names the column.
    pub column_span: Span<usize>,
    /// One of these (empty: any).
    pub equals: Vec<String>,
    /// At least this, in the unit of the file.
    pub min: Option<f64>,
    /// At most this, in the unit of the file.
    pub max: Option<f64>,
    /// Where the bench file says which.
    pub span: Span<usize>,
}

impl Condition {
    /// Whether another one lets the same rows through.
    pub fn asks_the_same(&self, other: &Condition) -> bool {
        (&self.column, &self.equals, self.min, self.max) == (&other.column, &other.equals, other.min, other.max)
    }
}

/// What a log needs of its file.
#[derive(Debug, Clone)]
pub struct Wanted {
    /// Which rows; all must hold.
    pub select: Vec<Condition>,
    /// Which columns.
    pub columns: Vec<Column>,
    /// Where the bench file names the log, for what is wrong with it as a whole.
    pub span: Span<usize>,
    /// Whether its rows may not be used to fit.
    pub held_out: bool,
}

/// The rows of a log.
#[derive(Debug, Clone, Default)]
pub struct Rows {
    /// Time \[s\], or row number.
    pub time: Vec<f64>,
    /// The channels.
    pub channels: BTreeMap<Channel, Vec<f64>>,
    /// What was left out, counted.
    pub remarks: Vec<Remark>,
}
/// The hash of a file from where it stands to its end.
pub fn hash_of(file: &mut File) -> io::Result<[u8; 32]> {
    let mut hash = Sha256::new();
    let mut buffer = vec![0; 1 << 16];
    loop {
        match file.read(&mut buffer)? {
            0 => return Ok(hash.finalize()),
            count => hash.update(&buffer[..count]),
        }
    }
}

/// That rows of one file are to fit for one log, and to judge for another.
pub fn shared(wanted: &[Wanted], rows: usize, name: &str) -> Problem {
    let log = wanted.iter().find(|w| w.held_out).map_or(0..0, |w| w.span.clone());
    Problem::at(log, format!("{rows} rows of `{name}` are both to fit and held out"), "held out here")
        .help("what judges must not have been fitted: `select` says which rows belong to a log")
}

/// That a log holds more numbers than can be taken, found at one of its rows.
pub fn too_long(row: u64) -> Problem {
    let most = limits::LOG_NUMBERS;
    Problem::whole(format!("the log has more than {most} numbers, reached at its row {row}"))
        .help("take part of it with `select`, keep every n-th row, or leave columns out of [columns]")
}
