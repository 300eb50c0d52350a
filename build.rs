//! Lists the catalogue files that are built into the program: every `catalogs/*/*.csv`, and families of gears.

use std::fmt::Write as _;
use std::path::Path;
use std::{env, fs};

fn main() {
    let root = env::var("CARGO_MANIFEST_DIR").expect("cargo sets it");
    let mut files = Vec::new();
    let kinds = ["alternatives", "gear_families", "gears", "modules", "motors"];
    for kind in kinds {
        let extension = if kind == "gear_families" { "toml" } else { "csv" };
        let folder = Path::new(&root).join("catalogs").join(kind);
        println!("cargo::rerun-if-changed={}", folder.display());
        let entries = fs::read_dir(&folder).expect("the catalogue folders exist");
        for path in entries.map(|e| e.expect("readable").path()) {
            if path.extension().is_some_and(|e| e == extension) {
                let name = path.file_name().expect("a file").to_string_lossy().into_owned();
                files.push((format!("catalogs/{kind}/{name}"), path));
            }
        }
    }
    files.sort();
    let mut code = String::from(
        "/// Name and text of every catalogue file that is built in.\nconst BUILTIN: &[(&str, &str)] = &[\n",
    );
    for (name, path) in files {
        writeln!(code, "    ({name:?}, include_str!({:?})),", path.display().to_string()).expect("a string");
    }
    code.push_str("];\n");
    let out = env::var("OUT_DIR").expect("cargo sets it");
    fs::write(Path::new(&out).join("builtin_catalogs.rs"), code).expect("the build folder can be written");
}
