//! The bodies of the fuzz targets: any bytes in, and a panic where a promise is broken.
//!
//! The one idea: a reader may refuse whatever it likes, but it says where and why; what it accepts is sane, and
//! what follows from it is computed to the end.

mod bench;
mod explore;
pub mod joint;
mod parts;
mod readers;
mod sane;
mod solve;

/// A body.
pub type Target = fn(&[u8]);

/// Every target with its name.
pub const TARGETS: &[(&str, Target)] = &[
    ("catalogue", readers::catalogue),
    ("requirement", readers::requirement),
    ("motion", readers::motion),
    ("rules", readers::rules),
    ("design", readers::design),
    ("study", readers::study),
    ("urdf", readers::mechanism),
    ("mjcf", readers::mechanism),
    ("bench", bench::bench),
    ("log", bench::log),
    ("mcap", bench::mcap),
    ("npz", bench::npz),
    ("parquet", bench::parquet),
    ("mgdb", bench::mgdb),
    ("solve", solve::solve),
    ("optimize", joint::optimize),
    ("http", explore::http),
    ("ask", explore::ask),
];

/// Runs one target.
///
/// # Panics
/// Where a promise is broken, and where there is no such target.
pub fn run(target: &str, bytes: &[u8]) {
    let (_, body) = TARGETS.iter().find(|(name, _)| *name == target).expect("a target of the list");
    body(bytes);
}
