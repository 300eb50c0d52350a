//! Readers that go by paths: bench files with their logs, and the Motor-Gearbox Database. Their files stand in a
//! folder of their own for as long as the body runs.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use gearwise::catalog::import::mgdb as importer;
use gearwise::measured::read::{read, read_for_row};
use gearwise::measured::{Bench, characterize, identify};

use super::parts::Parts;
use super::sane::{self, accepted, finite, not_negative, positive};

/// A folder that goes away with its files.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Folder {
        static NUMBER: AtomicU64 = AtomicU64::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let folder = std::env::temp_dir().join(format!("gearwise-fuzz-{}-{number}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder for the input");
        Folder(folder)
    }

    fn write(&self, name: &str, bytes: &[u8]) {
        // A name that is no file's (`..`, nothing) is one of those that the reader will not find.
        let _ = fs::write(self.0.join(name), bytes);
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

const MOTORS: &str = "id,commutation,terminals,current,resistance [ohm],torque_constant [N*m/A],rotor_inertia [kg*m^2],mass [kg],source,source_kind
outrunner,brushless,line_to_line,rms,0.5,0.05,1e-5,0.2,a sheet,datasheet
brushed,brushed,line_to_line,dc,0.5,0.05,1e-6,0.1,a sheet,datasheet
";

/// A log with a column for everything that the benches of the corpus name.
const LOG: &str = "t,i,w,q,tau,temp,run
0,1.0,60,0.0,-0.5,25,a
0.01,2.0,120,0.6,-1.0,25,a
0.02,1.5,150,2.1,-0.7,25,a
0.03,3.0,-60,2.4,1.5,26,b
0.04,4.0,0,2.1,0,26,b
0.05,4.5,10,2.2,0.3,26,b
";

/// A bench file; logs that it names are those of the input, or a small one.
pub fn bench(bytes: &[u8]) {
    let Some(parts) = Parts::new(bytes) else { return };
    // Names that lead out of the folder are not the reader's matter here, and a device has no end.
    if parts.main.contains("/dev") || parts.main.contains("/proc") {
        return;
    }
    let folder = Folder::new();
    folder.write("motors.csv", MOTORS.as_bytes());
    folder.write("log.csv", LOG.as_bytes());
    for (name, text) in &parts.others {
        folder.write(name, text.as_bytes());
    }
    folder.write("bench.toml", parts.main.as_bytes());
    evaluate(&folder.path("bench.toml"));
}

/// A log of any bytes under one of four benches; the first byte says under which.
pub fn log(bytes: &[u8]) {
    log_of("log.csv", bytes);
}

/// A recording of ROS 2 of any bytes, as [`log`].
pub fn mcap(bytes: &[u8]) {
    log_of("log.mcap", bytes);
}

/// A NumPy archive of any bytes, as [`log`].
pub fn npz(bytes: &[u8]) {
    log_of("log.npz", bytes);
}

/// A Parquet file of any bytes, as [`log`].
pub fn parquet(bytes: &[u8]) {
    log_of("log.parquet", bytes);
}

fn log_of(name: &str, bytes: &[u8]) {
    const DYNAMOMETER: &str = r#"catalog = ["motors.csv"]
actuator = { motor = "outrunner", ratio = 6 }
kind = "dynamometer"
[columns]
time = { name = "t", unit = "s" }
current = { name = "i", unit = "A", convention = "phase_amplitude" }
velocity = { name = "w", unit = "rpm", side = "motor" }
position = { name = "q", unit = "rad", side = "motor" }
torque = { name = "tau", unit = "N*m", side = "output" }
[[log]]
file = "log.csv"
select = { column = "run", equals = "a" }
[[log]]
file = "log.csv"
select = { column = "run", equals = ["b", "1.0"] }
use = "held_out"
"#;
    const TABLE: &str = r#"catalog = ["motors.csv"]
actuator = { motor = "brushed", ratio = 1 }
kind = "steady_table"
[columns]
current = { name = "i", unit = "A", convention = "dc" }
velocity = { name = "w", unit = "rad/s", side = "motor" }
torque = { name = "tau", unit = "mN*m", side = "output", sign = -1 }
[[log]]
file = "log.csv"
select = { column = "temp", min = 0, max = 100 }
"#;
    const STALL: &str = r#"actuator = { ratio = 7.5 }
kind = "stall"
columns.time = { name = "t", unit = "ms" }
columns.current = { name = "i", unit = "A", convention = "phase_amplitude" }
columns.torque = { name = "tau", unit = "N*m", side = "motor", gain_tolerance = "0.5 %" }
columns.winding_temperature = { name = "temp", unit = "degC" }
[motor]
pole_pairs = 7
current = "phase_amplitude"
[[log]]
file = "log.csv"
"#;
    const RECORDING: &str = r#"catalog = ["motors.csv"]
actuator = { motor = "outrunner", ratio = 9 }
kind = "dynamometer"
[columns]
time = { name = "/joint_states/header/stamp", unit = "s" }
current = { name = "/joint_states/effort/knee", unit = "A", convention = "q_axis" }
velocity = { name = "/joint_states/velocity/knee", unit = "rad/s", side = "motor" }
torque = { name = "/sensor/data", unit = "N*m", side = "output" }
[[log]]
file = "log.csv"
"#;
    let Some((kind, log)) = bytes.split_first() else { return };
    let folder = Folder::new();
    folder.write("motors.csv", MOTORS.as_bytes());
    folder.write(name, log);
    let bench = [DYNAMOMETER, TABLE, STALL, RECORDING][usize::from(*kind) % 4].replace("log.csv", name);
    folder.write("bench.toml", bench.as_bytes());
    evaluate(&folder.path("bench.toml"));
}

/// Reads a bench both ways; from what can be read, rows are made and effects sought.
fn evaluate(path: &Path) {
    if let Some(bench) = accepted(read(path)) {
        sane_bench(&bench);
        // What a handful of rows says is for no one to trust, but it must be said without a panic.
        if let Ok(reports) = identify::identify(&bench, &identify::Options::default()) {
            assert!(!reports.is_empty());
        }
    }
    if let Some(bench) = accepted(read_for_row(path, None, Vec::new())) {
        sane_bench(&bench);
        if let Ok(found) = characterize::characterize(&bench) {
            for quantity in found.outcomes.iter().flat_map(|o| &o.quantities) {
                assert!(!quantity.estimate.value.is_nan(), "{quantity:?}");
            }
        }
    }
}

fn sane_bench(bench: &Bench) {
    positive("a ratio", [bench.declared.ratio]);
    not_negative("a mass", bench.declared.mass);
    assert!(!bench.logs.is_empty() || bench.readings.terminals.is_some() || bench.readings.rotor.is_some());
    for log in &bench.logs {
        assert!(log.time.windows(2).all(|w| w[0] < w[1]), "time does not go forwards in {}", log.name);
        finite("a time", log.time.iter().copied());
        for (channel, values) in &log.channels {
            assert_eq!(values.len(), log.len());
            assert!(values.iter().all(|v| v.is_nan() || v.is_finite()), "{channel:?} of {} is infinite", log.name);
        }
    }
    if let Some(motor) = &bench.declared.motor {
        positive("motor constant", [motor.resistance, motor.torque_constant]);
    }
}

/// A folder of the Motor-Gearbox Database: `a_motors.csv`, then the files of the input.
pub fn mgdb(bytes: &[u8]) {
    let Some(parts) = Parts::new(bytes) else { return };
    let folder = Folder::new();
    folder.write("a_motors.csv", parts.main.as_bytes());
    for (name, text) in &parts.others {
        folder.write(name, text.as_bytes());
    }
    let Some(import) = accepted(importer::read(&folder.0)) else { return };
    assert!(!import.motors.is_empty() || !import.gears.is_empty());
    for remark in &import.remarks {
        assert!(!remark.message.is_empty() && remark.place.line > 0 && remark.place.column > 0, "{remark:?}");
    }
    // What is taken is what the catalogue's own reader takes.
    if let Err(errors) = import.catalog_files() {
        sane::told(&errors);
        panic!("an imported row that the catalogue refuses:\n{}", errors[0]);
    }
}
