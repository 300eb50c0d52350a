//! What is read at most: every limit on the size of an input, in one place.
//!
//! The one idea: a limit is far beyond what real files have and short of what brings a machine down. What is beyond
//! it is refused with the limit and with what to do; nothing is ever cut off.

use super::Problem;

/// A log: it is read as a stream, and only the columns that are asked for are kept \[bytes\].
pub const LOG_BYTES: u64 = 4 << 30;
/// A table that is held as a whole (`.csv`): catalogue, motion, trajectory \[bytes\].
pub const TABLE_BYTES: u64 = 512 << 20;
/// Any other text: requirement, design, bench, rules, lock, study, robot description \[bytes\].
pub const TEXT_BYTES: u64 = 64 << 20;
/// Rows of a table that is held as a whole: a million motors, or half an hour of motion at a kilohertz.
pub const TABLE_ROWS: usize = 2_000_000;
/// Numbers of a log that are held: rows times columns (23 million rows of seven columns, 1.3 GB).
pub const LOG_NUMBERS: usize = 1 << 28;
/// Numbers that any log may have: below this, [`log_numbers`] does not ask how large the file is.
const LOG_NUMBERS_ALWAYS: usize = 1 << 22;
/// Numbers per byte of a log: a packed log of measured values has at most one.
const LOG_NUMBERS_PER_BYTE: u64 = 8;
/// Size that any file may be unpacked to \[bytes\]; a larger one is bounded by its own size, see [`unpacked`].
const UNPACKED_ALWAYS: u64 = 64 << 20;
/// Ratio of unpacked to packed size of a file above [`UNPACKED_ALWAYS`].
const EXPANSION: u64 = 64;
/// Size of the message definitions of a recording, all together \[bytes\].
pub const SCHEMA_BYTES: usize = 8 << 20;
/// Messages inside one another in a message definition.
pub const SCHEMA_DEPTH: usize = 32;
/// Values of one message of a recording.
pub const MESSAGE_VALUES: usize = 1 << 21;
/// Size of a message in JSON \[bytes\].
pub const JSON_MESSAGE_BYTES: usize = 4 << 20;
/// Length of a column name that is listed \[bytes\].
pub const NAME_BYTES: usize = 1 << 10;
/// Joints of a requirement, a design or a trajectory.
pub const JOINTS: usize = 10_000;
/// Samples of the motions of all joints together.
pub const SAMPLES: usize = 10_000_000;
/// Tables and lists inside one another in a text (TOML, MJCF).
pub const DEPTH: usize = 200;
/// Elements of a robot description.
pub const ELEMENTS: u32 = 1_000_000;
/// Attributes of an element of a robot description.
pub const ATTRIBUTES: usize = 1000;
/// Characters of the name of a link, body or joint of a robot description.
pub const NAME_CHARACTERS: usize = 200;
/// Ratio of a gear of a bench: the largest compound gears have some thousands.
pub const RATIO: f64 = 1e4;
/// Order of a ripple over a turn of the motor that is looked for: its spectrum takes some 100 MB.
pub const ORDER: f64 = 4000.0;
/// Rest angle of a spring, either way \[rad\].
pub const REST_ANGLE: f64 = 100.0;
/// Designs of a sweep: joints times motors times ratios (some 1 kB each).
pub const SWEPT_DESIGNS: usize = 1_000_000;
/// Mistakes of one file that are collected.
pub const PROBLEMS: usize = 10_000;
/// Characters of each part of a report of a mistake: message, label, help.
pub const REPORT_CHARACTERS: usize = 3000;
/// Duration of a planned run \[s\].
pub const PLAN_TIME: f64 = 3600.0;
/// Ratios along a front of each motor.
pub const FRONT_POINTS: i64 = 5000;
/// Points of the grid of a study.
pub const GRID_POINTS: u64 = 1_000_000_000;
/// Robots of a study: requirements times points of the grid.
pub const ROBOTS: u64 = 1 << 40;
/// Pixels of a picture: 256 MB while it is drawn.
pub const PIXELS: u64 = 1 << 26;

/// Numbers of a log of this size that are held; a text counts as the numbers that take its memory.
pub fn log_numbers(bytes: u64) -> usize {
    let most = bytes.saturating_mul(LOG_NUMBERS_PER_BYTE).clamp(LOG_NUMBERS_ALWAYS as u64, LOG_NUMBERS as u64);
    usize::try_from(most).unwrap_or(LOG_NUMBERS)
}

/// Size that a file of this size is unpacked to at most \[bytes\].
pub fn unpacked(bytes: u64) -> u64 {
    bytes.saturating_mul(EXPANSION).max(UNPACKED_ALWAYS)
}

/// A problem with the size of a file; `None` where it is small enough.
pub(crate) fn bytes(found: u64, most: u64) -> Option<Problem> {
    (found > most).then(|| {
        let help = match most {
            LOG_BYTES => "cut the recording into several logs, or leave out columns and samples that are not needed",
            TABLE_BYTES => "split the file, or leave out rows that are not needed",
            _ => "is it the right file? Large tables belong into .csv files, which may be larger",
        };
        Problem::whole(format!("the file has {}; at most {} are read", size(found), size(most))).help(help)
    })
}

/// That there are more than `most` of something.
pub fn too_many(what: &str, found: impl std::fmt::Display, most: impl std::fmt::Display) -> String {
    format!("{found} {what} are more than can be taken: at most {most}")
}

/// Bytes for people.
fn size(bytes: u64) -> String {
    match bytes {
        0..1_048_576 => format!("{bytes} bytes"),
        1_048_576..1_073_741_824 => format!("{} MiB", crate::words::number(bytes as f64 / 1_048_576.0)),
        _ => format!("{} GiB", crate::words::number(bytes as f64 / 1_073_741_824.0)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_is_told_with_what_to_do() {
        assert!(bytes(TABLE_BYTES, TABLE_BYTES).is_none());
        let problem = bytes(5 << 30, LOG_BYTES).unwrap();
        assert_eq!(problem.message, "the file has 5 GiB; at most 4 GiB are read");
        assert!(problem.help.unwrap().contains("several logs"));
        assert!(bytes(TEXT_BYTES + 1, TEXT_BYTES).unwrap().help.unwrap().contains("right file"));
    }
}
