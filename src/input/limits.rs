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
/// Joints of a requirement, a design or a trajectory.
pub const JOINTS: usize = 10_000;
/// Samples of the motions of all joints together.
pub const SAMPLES: usize = 10_000_000;
/// Tables and lists inside one another in a text (TOML, MJCF).
pub const DEPTH: usize = 200;
/// Elements of a robot description.
pub const ELEMENTS: u32 = 1_000_000;
/// Points of the grid of a study.
pub const GRID_POINTS: u64 = 1_000_000_000;
/// Robots of a study: requirements times points of the grid.
pub const ROBOTS: u64 = 1 << 40;
/// Pixels of a picture: 256 MB while it is drawn.
pub const PIXELS: u64 = 1 << 26;

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
pub(crate) fn too_many(what: &str, found: impl std::fmt::Display, most: impl std::fmt::Display) -> String {
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
