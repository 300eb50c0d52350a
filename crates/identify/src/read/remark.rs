//! What was assumed or left out while a log was read.

use std::fmt;

/// What was assumed of a column, or left out of a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Remark {
    /// A column was measured at the motor and is brought to the output by the ratio.
    FromMotor(&'static str),
    /// A column names no side.
    NoSide(&'static str),
    /// A current names no convention: it is taken as this one.
    CurrentConvention(&'static str),
    /// A torque of the drive is taken as a current by the declared torque constant.
    OfTorque(&'static str),
    /// A voltage names no convention.
    VoltageConvention,
    /// So many rows have a repeated time.
    Repeated(usize),
    /// So many rows have no time.
    Timeless(usize),
    /// A column of a recording is of another topic than the time.
    Latest {
        /// The channel's key.
        key: &'static str,
        /// How old the oldest of its values is where it is used \[µs\].
        microseconds: u64,
    },
    /// A column has no number in any of its cells.
    Empty {
        /// The channel's key.
        key: &'static str,
        /// How many cells it has.
        cells: usize,
    },
    /// Cells of a column are missing.
    Missing {
        /// The channel's key.
        key: &'static str,
        /// How many are missing.
        missing: usize,
        /// Of how many.
        cells: usize,
    },
}

impl fmt::Display for Remark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rows = |f: &mut fmt::Formatter<'_>, count: usize, what: &str| match count {
            1 => write!(f, "1 row {what} was left out"),
            count => write!(f, "{count} rows {what} were left out"),
        };
        match self {
            Remark::FromMotor(key) => {
                write!(f, "`{key}` was measured at the motor and is brought to the output by the ratio")
            }
            Remark::NoSide(key) => write!(f, "`{key}` names no side and is taken at the output"),
            Remark::CurrentConvention(word) => {
                write!(f, "`current` names no convention and is taken as that of the motor's row, {word}")
            }
            Remark::OfTorque(key) => {
                write!(f, "`{key}` is taken as the current that makes it by the declared torque constant")
            }
            Remark::VoltageConvention => f.write_str("`voltage` names no convention and is taken on the q axis"),
            Remark::Latest { key, microseconds } => {
                let age = gearwise_model::words::number(*microseconds as f64 / 1e6);
                write!(f, "`{key}` is of another topic than `time`: each row has its latest value, at most {age} s old")
            }
            Remark::Repeated(count) => rows(f, *count, "with a repeated time"),
            Remark::Timeless(count) => rows(f, *count, "without time"),
            Remark::Empty { key, cells } => {
                write!(f, "`{key}` was left out: none of its {cells} cells holds a number")
            }
            Remark::Missing { key, missing, cells } => write!(f, "{missing} of {cells} cells of `{key}` are missing"),
        }
    }
}
