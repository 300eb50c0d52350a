//! A folder with one good file of each kind, and the program run in it.

use std::fs;
use std::io::Write;
use std::process::{Command, Stdio};

use tempfile::TempDir;

pub const REQUIREMENT: &str = r#"name = "leg"
[bus]
voltage = "48 V"
drive_current = "40 A"

[[joint]]
name = "knee"
count = 2
ratio = { min = 3, max = 30 }
motor_drag = "off"
gear = { efficiency = 0.95, mass = "150 g", inertia = "2e-6 kg*m^2" }
motion = "knee.csv"
objective = "loss"
[joint.limits]
reflected_inertia = "0.02 kg*m^2"
safety = 1.2
"#;

pub use super::mistakes::MOTION;

pub const MOTORS: &str = "id,terminals,current,resistance [ohm],inductance [mH],torque_constant [N*m/A],rotor_inertia [g*cm^2],mass [g],pole_pairs,continuous_torque [N*m],peak_current [A],max_winding_temperature [degC],max_speed [rpm],source,source_kind
alpha-1,line_to_line,dc,0.5,0.2,0.05,300,200,7,9,60,120,30000,a sheet,datasheet
alpha-2,line_to_line,dc,0.7,0.3,0.06,320,210,7,9,60,120,30000,a sheet,datasheet
";

pub const DESIGN: &str = "requirement = \"robot.toml\"
catalog = [\"motors.csv\"]

[[joint]]
name = \"knee\"
motor = \"alpha-1\"
ratio = 9
";

pub const RULES: &str = "[[rule]]\nrule = \"voltage-headroom\"\nmin = 0.05\nreason = \"a stiff bus\"\n";

/// What the program did.
pub struct Ran {
    pub status: i32,
    pub out: String,
    pub err: String,
}

/// A folder with requirement, motion, motors, design and rules.
pub fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let files = [
        ("robot.toml", REQUIREMENT),
        ("knee.csv", MOTION),
        ("motors.csv", MOTORS),
        ("design.toml", DESIGN),
        ("rules.toml", RULES),
    ];
    files.iter().for_each(|(name, text)| fs::write(folder.path().join(name), text).unwrap());
    folder
}

/// Runs the program in the folder with a text on standard input.
pub fn run_with(folder: &TempDir, arguments: &[&str], stdin: &[u8]) -> Ran {
    let mut child = Command::new(env!("CARGO_BIN_EXE_gearwise"))
        .args(arguments)
        .current_dir(folder.path())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // Who does not read it closes the pipe.
    let _ = child.stdin.take().unwrap().write_all(stdin);
    let output = child.wait_with_output().unwrap();
    Ran {
        status: output.status.code().unwrap(),
        out: String::from_utf8(output.stdout).unwrap(),
        err: String::from_utf8(output.stderr).unwrap(),
    }
}

/// Runs the program in the folder.
pub fn run(folder: &TempDir, arguments: &[&str]) -> Ran {
    run_with(folder, arguments, b"")
}
