//! Logs as people have them: the same log in every format gives the same bytes of answer, and what is wrong with one is said with
//! its file and column.

mod arrays;
mod bags;
mod channels;
mod write;

use std::collections::BTreeMap;
use std::process::Command;

use gearwise::input::sha256;
use gearwise::measured::Bench;
use gearwise::measured::read::read;

use crate::common::repository;

/// The columns of a log by their names.
type Columns = BTreeMap<String, Vec<f64>>;

/// The columns of a CSV file of the repository.
fn columns(name: &str) -> Columns {
    let mut reader = csv::Reader::from_path(repository(name)).unwrap();
    let header: Vec<String> = reader.headers().unwrap().iter().map(String::from).collect();
    let mut columns: Columns = header.iter().map(|name| (name.clone(), Vec::new())).collect();
    for record in reader.records() {
        for (name, cell) in header.iter().zip(&record.unwrap()) {
            columns.get_mut(name).unwrap().push(cell.parse().unwrap());
        }
    }
    columns
}

/// The motor of [`BENCH`].
const MOTORS: &str = "id,commutation,terminals,current,resistance [ohm],torque_constant [N*m/A],source,source_kind
t-motor-ri50,brushless,line_to_line,rms,0.5,0.05,a sheet,datasheet
";

/// A bench that reads, of one log `log.ENDING`.
const BENCH: &str = r#"actuator = { motor = "t-motor-ri50", ratio = 9 }
kind = "dynamometer"
[columns]
time = { name = "t", unit = "s" }
current = { name = "i", unit = "A", convention = "phase_amplitude" }
velocity = { name = "w", unit = "rad/s", side = "motor" }
torque = { name = "tau", unit = "N*m", side = "output" }
[[log]]
file = "log.csv"
"#;

/// Reads [`BENCH`], changed, with a log; an error is the report that a person sees.
fn outcome(bench: &str, name: &str, log: &[u8]) -> Result<Bench, String> {
    let folder = tempfile::tempdir().unwrap();
    let bench = format!("catalog = [\"motors.csv\"]\n{}", bench.replace("log.csv", name));
    std::fs::write(folder.path().join("bench.toml"), bench).unwrap();
    std::fs::write(folder.path().join("motors.csv"), MOTORS).unwrap();
    std::fs::write(folder.path().join(name), log).unwrap();
    read(&folder.path().join("bench.toml")).map_err(|errors| errors.iter().map(ToString::to_string).collect())
}

/// The report must have all of these in it.
fn refused(bench: &str, name: &str, log: &[u8], parts: &[&str]) {
    let report = outcome(bench, name, log).expect_err("this must be refused");
    for part in parts {
        assert!(report.contains(part), "`{part}` is not in:\n{report}");
    }
}

/// A few rows of [`BENCH`].
fn few() -> Vec<(&'static str, Vec<f64>)> {
    vec![
        ("t", vec![0.0, 0.1, 0.2, 0.3]),
        ("i", vec![1.0, 2.0, 3.0, -4.0]),
        ("w", vec![0.1, 0.2, 0.3, 1.0 / 3.0]),
        ("tau", vec![5.0, 6.0, 7.0, 8.0]),
    ]
}

/// The answer of `identify --json` over the example's logs, in a format, with names and hashes of the logs that CSV would have.
fn answer(ending: &str, columns_of: &str, write: impl Fn(&Columns) -> Vec<u8>) -> String {
    let folder = tempfile::tempdir().unwrap();
    let bench = std::fs::read_to_string(repository("requirements/bench/leg_actuator.toml")).unwrap();
    let table = &bench[bench.find("[columns]").unwrap()..bench.find("[[log]]").unwrap()];
    std::fs::write(folder.path().join("bench.toml"), bench.replace(table, columns_of).replace(".csv", ending)).unwrap();
    let mut hashes = Vec::new();
    for k in 1..=3 {
        let bytes = write(&columns(&format!("requirements/bench/leg_actuator_{k}.csv")));
        hashes.push((sha256([&bytes[..]]), k));
        std::fs::write(folder.path().join(format!("leg_actuator_{k}{ending}")), bytes).unwrap();
    }
    let output = Command::new(env!("CARGO_BIN_EXE_gearwise"))
        .args(["identify", "bench.toml", "--json"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let mut answer = String::from_utf8(output.stdout).unwrap();
    for (hash, k) in hashes {
        assert!(answer.contains(&hash), "the hash of log {k}");
        answer = answer.replace(&hash, &format!("log {k}"));
    }
    answer.replace(ending, ".csv")
}

/// The table of columns of the example, with each name made another one.
fn renamed(name: impl Fn(&str) -> String) -> String {
    let bench = std::fs::read_to_string(repository("requirements/bench/leg_actuator.toml")).unwrap();
    let mut table = bench[bench.find("[columns]").unwrap()..bench.find("[[log]]").unwrap()].to_string();
    for column in columns("requirements/bench/leg_actuator_1.csv").keys() {
        table = table.replace(&format!("\"{column}\""), &format!("\"{}\"", name(column)));
    }
    table
}

/// CSV with the shortest text of each number that reads back as it.
fn csv(columns: &Columns) -> Vec<u8> {
    let names: Vec<&str> = columns.keys().map(String::as_str).collect();
    let mut text = names.join(",");
    for row in 0..columns.values().next().unwrap().len() {
        let cells: Vec<String> = columns.values().map(|v| v[row].to_string()).collect();
        text += &format!("\n{}", cells.join(","));
    }
    (text + "\n").into_bytes()
}

/// Where the columns of the example are in a recording of joint states.
const FIELDS: [(&str, &str); 6] = [
    ("t_s", "/joint_states/header/stamp"),
    ("theta_rad", "/joint_states/position/knee"),
    ("omega_radps", "/joint_states/velocity/knee"),
    ("iq_a", "/joint_states/effort/knee"),
    ("tau_nm", "/joint_states/effort/knee_sensor"),
    ("winding_degc", "/joint_states/effort/knee_winding"),
];

/// The example as a recording of joint states.
fn recording(columns: &Columns, chunks: write::Chunks) -> Vec<u8> {
    let mut file = write::Mcap::default();
    let topic = file.topic("/joint_states", "sensor_msgs/msg/JointState", "ros2msg", write::JOINT_STATE, "cdr");
    for (row, time) in columns["t_s"].iter().enumerate() {
        let stamp = 1_700_000_000_000_000_000 + (time * 1e9).round() as u64;
        let of = |name: &str| columns[name][row];
        let names = ["knee", "knee_sensor", "knee_winding"];
        let (position, velocity) = ([of("theta_rad"), 0.0, 0.0], [of("omega_radps"), 0.0, 0.0]);
        let effort = [of("iq_a"), of("tau_nm"), of("winding_degc")];
        file.message(topic, stamp, &write::joint_state(stamp, &names, &position, &velocity, &effort));
    }
    file.file(chunks)
}

#[test]
fn the_same_log_in_every_format_gives_the_same_answer() {
    let same = renamed(str::to_string);
    let expected = answer(".csv", &same, csv);
    assert!(expected.contains("coulomb_friction"));
    let own = |columns: &Columns| columns.clone().into_iter().collect::<Vec<_>>();
    assert_eq!(answer(".parquet", &same, |c| write::parquet(&own(c), write::Packed::Snappy)), expected, "Parquet");
    for packed in [false, true] {
        assert_eq!(answer(".npz", &same, |c| write::npz(&own(c), packed)), expected, "npz, {packed}");
    }
    // In a recording the names are topics and fields.
    let recorded = renamed(|name| FIELDS.iter().find(|(column, _)| *column == name).unwrap().1.into());
    for chunks in [write::Chunks::No, write::Chunks::Plain, write::Chunks::Lz4, write::Chunks::Zstd] {
        assert_eq!(answer(".mcap", &recorded, |c| recording(c, chunks)), expected, "MCAP, {chunks:?}");
    }
}
