//! Benches of real logs, which are no part of the repository.

use std::path::{Path, PathBuf};

/// Where the bench files say that the data are, from their own place.
const NAMED: &str = "GEARWISE_REAL_DATA";

/// The folder of the data: `GEARWISE_REAL_DATA`, else `data` in `GEARWISE_SHARED`; `None` where neither is set. Nothing outside of the
/// repository is read without being told so.
pub fn data() -> Option<PathBuf> {
    let of = |name: &str| std::env::var_os(name).map(PathBuf::from);
    of("GEARWISE_REAL_DATA").or_else(|| Some(super::shared()?.join("data")))
}

/// Runs a test on each set that is there, by the path of a copy of its bench file with the paths of the folder of the data, and says last how
/// many are not.
pub fn on_each<T>(names: &[&str], mut test: impl FnMut(&str, &Path) -> T) -> Vec<T> {
    let benches = super::repository("tests/fixtures/benches");
    let Some(data) = data() else {
        println!("not run: {} sets", names.len());
        return Vec::new();
    };
    let data = std::path::absolute(data).expect("a folder's name");
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
        let folder = tempfile::tempdir().expect("a folder");
        for entry in std::fs::read_dir(&benches).expect("the benches").map(|e| e.expect("a file").path()) {
            let copy = folder.path().join(entry.file_name().expect("a name"));
            std::fs::copy(&entry, copy).expect("it can be copied");
        }
        std::fs::write(folder.path().join(&file), text).expect("it can be written");
        results.push(test(name, &folder.path().join(file)));
    }
    if absent > 0 {
        println!("not run: {absent} sets");
    }
    results
}
