//! Which format a log file has: its name says it, and what it begins with must agree.

use std::fs::File;
use std::io::{Read, Seek};
use std::path::Path;

use super::arrays::Reader;
use super::{bag, npz};
use gearwise_model::input::Problem;

/// How a log is read.
#[derive(Debug, Clone, Copy)]
pub enum Format {
    /// Lines of text: CSV.
    Lines,
    /// Arrays, one for each column.
    Arrays(Reader),
}

/// The formats of arrays: how a name ends, how the file begins, what it is called.
const ARRAYS: &[(&str, &[u8], &str, Reader)] = &[
    ("parquet", b"PAR1", "a Parquet file", PARQUET),
    ("mcap", b"\x89MCAP0\r\n", "an MCAP file", bag::read),
    ("npz", b"PK", "a NumPy archive (.npz, a ZIP)", npz::read),
];

#[cfg(feature = "parquet")]
const PARQUET: Reader = super::parquet::read;
#[cfg(not(feature = "parquet"))]
const PARQUET: Reader = |_, _| {
    Err(vec![Problem::whole(gearwise_model::words::not_built("Parquet")).help("or save the log as .npz or CSV")])
};

/// What a file begins with that is not read: what it is, and the line that makes one of it that is.
const OTHERS: &[(&[u8], &str, &str)] = &[
    (b"\x93NUMPY", "one NumPy array (.npy)", "name its columns: np.savez(\"log.npz\", time=a[:, 0], current=a[:, 1])"),
    (b"SQLite format 3\0", "a ROS 2 bag in SQLite (.db3)", "mcap convert LOG.db3 log.mcap"),
    (b"#ROSBAG V", "a ROS 1 bag", "mcap convert LOG.bag log.mcap"),
    (
        b"\x89HDF\r\n\x1a\n",
        "an HDF5 file (.h5, .mat)",
        "save what is needed: np.savez(\"log.npz\", time=f[\"time\"][:], current=f[\"current\"][:])",
    ),
    (
        b"MATLAB 5.0 MAT-file",
        "a MATLAB file (.mat)",
        "in MATLAB: parquetwrite(\"log.parquet\", table(time, current, velocity))",
    ),
    (b"ARROW1", "a Feather (Arrow) file", "pandas.read_feather(\"log\").to_parquet(\"log.parquet\")"),
    (b"PARE", "an encrypted Parquet file", "save it without encryption"),
    (b"\x1f\x8b", "a gzip archive", "unpack it first: gunzip FILE"),
    (b"\x28\xb5\x2f\xfd", "a file that zstd has compressed", "unpack it first: zstd -d FILE"),
    (b"\x04\x22\x4d\x18", "a file that LZ4 has compressed", "unpack it first: lz4 -d FILE"),
];

impl Format {
    /// The format of a file, which is left at its beginning.
    ///
    /// # Errors
    /// What it is, where it is not read, or not what its name says.
    pub fn of(path: &Path, file: &mut File) -> Result<Format, Problem> {
        let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        let named = ARRAYS.iter().find(|(name, ..)| *name == ending);
        // A pipe is read once.
        if !file.metadata().is_ok_and(|m| m.is_file()) {
            return match named {
                None => Ok(Format::Lines),
                Some((_, _, what, _)) => Err(Problem::whole(format!("{what} cannot be read from a pipe"))),
            };
        }
        let cannot =
            |e: std::io::Error| Problem::whole(format!("cannot read the file: {}", gearwise_model::words::reason(&e)));
        let mut first = Vec::new();
        file.by_ref().take(32).read_to_end(&mut first).map_err(cannot)?;
        file.rewind().map_err(cannot)?;
        if let Some((_, what, help)) = OTHERS.iter().find(|(begins, ..)| first.starts_with(begins)) {
            return Err(Problem::whole(format!("this is {what}, which is not read as a log")).help(*help));
        }
        let found = ARRAYS.iter().find(|(_, begins, ..)| first.starts_with(begins));
        match (named, found) {
            (Some((_, begins, _, reader)), _) if first.starts_with(begins) => Ok(Format::Arrays(*reader)),
            (Some(_), _) if first.is_empty() => Err(Problem::whole("the file is empty")),
            (Some((_, _, what, _)), Some((_, _, is, _))) => {
                Err(Problem::whole(format!("this is not {what}, as its name says, but {is}")).help("rename it"))
            }
            (Some((ending, _, what, _)), None) => {
                let help = format!("is it cut off, or text? A name that does not end in .{ending} is read as CSV");
                Err(Problem::whole(format!("this is not {what}, as its name says")).help(help))
            }
            // Text may begin with these letters as well; a header that does has no such bytes after it.
            (None, Some((ending, _, is, _))) if first.iter().any(|b| *b < 9) => {
                let what = if *ending == "npz" { "a ZIP archive" } else { is };
                let help = if *ending == "npz" {
                    "a spreadsheet can be saved as CSV; the name of a NumPy archive ends in .npz".to_string()
                } else {
                    format!("its name has to end in .{ending}")
                };
                Err(Problem::whole(format!("this is {what}, not a CSV file")).help(help))
            }
            (None, _) => Ok(Format::Lines),
        }
    }
}
