//! Benches of real logs, which are no part of the repository.

use std::path::{Path, PathBuf};

/// Where the bench files say that the data are, from their own place.
const NAMED: &str = "../../../../shared/data";

/// The folder of the data: `GEARWISE_REAL_DATA`, else `data` in `GEARWISE_SHARED`, else `../shared/data`.
pub fn data() -> PathBuf {
    let of = |name: &str| std::env::var_os(name).map(PathBuf::from);
    of("GEARWISE_REAL_DATA")
        .or_else(|| Some(of("GEARWISE_SHARED")?.join("data")))
        .unwrap_or_else(|| super::repository("../shared/data"))
}

/// Runs a test on each set that is there, by the path of its bench file, and says last how many are not. Where the
/// environment names the folder, the bench file is a copy with the paths of that folder.
pub fn on_each<T>(names: &[&str], mut test: impl FnMut(&str, &Path) -> T) -> Vec<T> {
    let benches = super::repository("tests/fixtures/benches");
    let elsewhere = ["GEARWISE_REAL_DATA", "GEARWISE_SHARED"].iter().any(|name| std::env::var_os(name).is_some());
    let data = std::path::absolute(data()).expect("a folder's name");
    let mut results = Vec::new();
    let mut absent = 0;
    for name in names {
        let file = format!("{name}.toml");
        let text = std::fs::read_to_string(benches.join(&file)).unwrap_or_else(|e| panic!("{file}: {e}"));
        let text = text.replace(NAMED, &data.to_string_lossy());
        let wanted = text.lines().filter_map(|line| line.strip_prefix("file = \"")?.strip_suffix('"'));
        if !wanted.map(Path::new).all(Path::exists) {
            absent += 1;
            continue;
        }
        if elsewhere {
            let folder = tempfile::tempdir().expect("a folder");
            for entry in std::fs::read_dir(&benches).expect("the benches").map(|e| e.expect("a file").path()) {
                let copy = folder.path().join(entry.file_name().expect("a name"));
                std::fs::copy(&entry, copy).expect("it can be copied");
            }
            std::fs::write(folder.path().join(&file), text).expect("it can be written");
            results.push(test(name, &folder.path().join(file)));
        } else {
            results.push(test(name, &benches.join(file)));
        }
    }
    if absent > 0 {
        println!("not run: {absent} sets");
    }
    results
}
