//! Pictures as PNG.

use std::fs;
use std::process::Command;

use crate::common::repository;

#[test]
fn a_png_is_whole_and_the_same_for_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let draw = |arguments: &[&str], threads: &str| {
        let png = folder.path().join(format!("{threads}.png"));
        let run = Command::new(env!("CARGO_BIN_EXE_gearwise"))
            .args(arguments)
            .args(["--threads", threads, "--plot", png.to_str().unwrap()])
            .current_dir(repository(""))
            .output()
            .unwrap();
        assert_eq!(run.status.code(), Some(0), "{}", String::from_utf8_lossy(&run.stderr));
        fs::read(png).unwrap()
    };
    for arguments in [
        &["identify", "requirements/bench/leg_actuator.toml"][..],
        &["characterize", "requirements/bench/motor_on_bench.toml"],
        &["rank"],
    ] {
        let bytes = draw(arguments, "1");
        assert_eq!(&bytes[..8], b"\x89PNG\r\n\x1a\n");
        assert_eq!(&bytes[bytes.len() - 8..bytes.len() - 4], b"IEND");
        assert!(bytes.len() > 10_000 && bytes == draw(arguments, "4"), "{arguments:?}");
    }
}
