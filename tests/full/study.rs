//! The results of a study as a Parquet file.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::shell::Workspace;

/// The rows of the results, each as column to cell.
fn rows(out: &Path) -> Vec<BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_path(out.join("results.csv")).unwrap();
    let header = reader.headers().unwrap().clone();
    let row = |r: csv::StringRecord| header.iter().zip(&r).map(|(h, c)| (h.to_string(), c.to_string())).collect();
    reader.records().map(|r| row(r.unwrap())).collect()
}

#[test]
fn parquet_has_the_cells_of_the_csv_with_their_types() {
    use parquet::basic::Type;
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;
    let workspace = Workspace::new();
    let study =
        "requirement = \"robot.toml\"\n[grid]\n\"bus.voltage\" = [\"24 V\", \"48 V\"]\n\"scale.torque\" = [1, 1.5]\n";
    fs::write(workspace.path("study.toml"), study).unwrap();
    let run = workspace.run(&["study", "study.toml", "--out", "out"].map(String::from));
    assert_eq!(run.status.code(), Some(0), "{}", String::from_utf8_lossy(&run.stderr));
    let out = workspace.path("out");
    let rows = rows(&out);
    let reader = SerializedFileReader::new(fs::File::open(out.join("results.parquet")).unwrap()).unwrap();
    let schema = reader.metadata().file_metadata().schema_descr_ptr();
    let physical = |name: &str| {
        schema.columns().iter().find(|c| c.name() == name).unwrap_or_else(|| panic!("{name}")).physical_type()
    };
    assert_eq!(physical("robot"), Type::INT64);
    assert_eq!(physical("grid_bus_voltage_v"), Type::DOUBLE);
    assert_eq!(physical("loss_w"), Type::DOUBLE);
    assert_eq!(physical("motor"), Type::BYTE_ARRAY);
    let mut count = 0;
    for (row, typed) in rows.iter().zip(reader.get_row_iter(None).unwrap()) {
        for (name, field) in typed.unwrap().into_columns() {
            let cell = &row[&name];
            match field {
                Field::Null => assert!(cell.is_empty(), "{name}: {cell}"),
                Field::Long(value) => assert_eq!(cell.parse(), Ok(value), "{name}"),
                Field::Double(value) => assert_eq!(cell.parse(), Ok(value), "{name}"),
                Field::Str(value) => assert_eq!(*cell, value, "{name}"),
                other => panic!("{name}: {other:?}"),
            }
        }
        count += 1;
    }
    assert_eq!(count, rows.len());
    assert_eq!(reader.metadata().file_metadata().num_rows() as usize, rows.len());
}
