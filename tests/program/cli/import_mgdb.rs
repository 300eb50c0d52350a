//! The Motor-Gearbox Database into catalogue files: small databases in which everything goes wrong
//! once, and the real one where it is at hand.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use approx::assert_relative_eq;
use gearwise::catalog::convention::Commutation;
use gearwise::catalog::{Catalog, Gear, GearKind, Motor, SourceKind};
use serde_json::Value;

use crate::common::repository;

const MOTORS: &str = "key,manufacturer,ID,type,V,k_t,R,L,mass,inertia,omega_nl,I_nl,I_nom,max_int_torque,max_int_speed,\
                      max_cont_speed,max_cont_power,coulomb_friction,viscous_friction,Rth1,Rth2";
const GEARS: &str =
    "key,manufacturer,ID,type,stages,ratio,mass,inertia,efficiency,direction,max_int_torque,max_cont_torque";

/// A database in a folder of its own, and a folder for what is made of it.
struct Database {
    folder: tempfile::TempDir,
}

impl Database {
    fn new(files: &[(&str, String)]) -> Database {
        let database = Database { folder: tempfile::tempdir().unwrap() };
        for (path, text) in files {
            let path = database.path("db").join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        database
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn import(&self, more: &[&str]) -> Output {
        import(&self.path("db"), &self.path("out"), more)
    }

    fn json(&self, more: &[&str]) -> Value {
        let output = self.import(&[more, &["--json"]].concat());
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        serde_json::from_slice(&output.stdout).unwrap()
    }

    fn catalog(&self) -> Catalog {
        Catalog::read(&[self.path("out")]).unwrap_or_else(|e| panic!("{}", e[0]))
    }

    /// Every file below `out`, hidden ones too, with its text.
    fn written(&self) -> HashMap<PathBuf, String> {
        let mut files = HashMap::new();
        let mut folders = vec![self.path("out")];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
                match entry.path() {
                    path if path.is_dir() => folders.push(path),
                    path => drop(files.insert(path.clone(), fs::read_to_string(path).unwrap())),
                }
            }
        }
        files
    }
}

fn import(folder: &Path, out: &Path, more: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gearwise"));
    command.args(["import", "mgdb"]).arg(folder).arg("--out").arg(out).args(more).output().unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn lines(header: &str, rows: &[&str]) -> String {
    format!("{header}\n{}\n", rows.join("\n"))
}

fn motor<'c>(catalog: &'c Catalog, id: &str) -> &'c Motor {
    catalog.motor(id).unwrap_or_else(|near| panic!("no motor {id}; {near:?}"))
}

fn gear<'c>(catalog: &'c Catalog, id: &str) -> &'c Gear {
    catalog.gears.iter().find(|g| g.id == id).unwrap_or_else(|| panic!("no gear {id}"))
}

/// `(line, key, code)` of every remark of a kind in a file.
fn remarks(result: &Value, kind: &str, file: &str) -> Vec<(u64, String, String)> {
    let text = |r: &Value, key: &str| r[key].as_str().unwrap().to_string();
    let all = result[kind].as_array().unwrap().iter().filter(|r| text(r, "file").ends_with(file));
    all.map(|r| (r["line"].as_u64().unwrap(), text(r, "key"), text(r, "code"))).collect()
}

fn has(found: &[(u64, String, String)], line: u64, key: &str, code: &str) -> bool {
    found.iter().any(|(l, k, c)| (*l, k.as_str(), c.as_str()) == (line, key, code))
}

/// The rest of a motor's row after its type.
const REST: &str = "24,0.05,0.5,0.0001,0.3,1e-5,470,0.2,4,inf,900,800,Inf";

#[test]
fn motors_keep_their_numbers_and_missing_friction_is_derived() {
    let rows = [
        format!("AC_B1,Acme,B1,BLDC,{REST},NaN,NaN,0.5,6"),
        format!("AC_D1,Acme,D1,DC,{REST},,,,"),
        format!("AC_D2,Acme,D2,DC,{REST},0.002,,,"),
        format!("AC_B2,Acme,B2,BLDC,{REST},0.003,4e-6,,"),
        // No no-load current: (24 − 0.05·460)/0.5 = 2 A, and (24 − 0.05·490)/0.5 = −1 A.
        "AC_B3,Acme,B3,BLDC,24,0.05,0.5,,,,460,,,,,,,,,,".into(),
        "AC_B4,Acme,B4,BLDC,24,0.05,0.5,,,,490,,,,,,,,,,".into(),
        "AC_D3,Acme,D3,DC,24,0.05,0.5,,,,460,,,,,,,,,,".into(),
        "AC_B5,Acme,B5,BLDC,24,0.05,0.5,,,,,,,,,,,,,,".into(),
        "AC_D4,Acme,D4,DC,24,0.05,0.5,,,,,,,,,,,,,,".into(),
    ];
    let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
    let database = Database::new(&[("Acme/acme_motors.csv", lines(MOTORS, &rows))]);
    let result = database.json(&[]);
    assert_eq!((&result["motors"], &result["gears"]), (&9.into(), &1.into()));
    let catalog = database.catalog();
    let b1 = motor(&catalog, "ac-b1");
    assert_eq!((b1.torque_constant, b1.back_emf_constant, b1.resistance, b1.inductance), (0.05, 0.05, 0.5, Some(1e-4)));
    assert_eq!((b1.rotor_inertia, b1.mass, b1.continuous_current), (Some(1e-5), Some(0.3), Some(4.0)));
    assert_eq!((b1.peak_torque, b1.peak_current, b1.max_speed), (None, None, Some(900.0)));
    assert_eq!((b1.thermal_resistance, b1.sheet.voltage.unwrap().value), (Some(6.5), 24.0));
    assert_eq!((b1.conventions.commutation, b1.source_kind), (Commutation::Brushed, SourceKind::Secondary));
    assert_eq!(b1.source, "Acme B1, as collected in MGDB");
    assert!(b1.note.contains("AC_B1 of MGDB") && b1.note.contains("equivalent DC machine"), "{}", b1.note);
    let friction = |id: &str| (motor(&catalog, id).coulomb_friction, motor(&catalog, id).viscous_friction);
    assert_eq!(friction("ac-b1"), (Some(0.0), Some(0.05 * 0.2 / 470.0)));
    assert_eq!(friction("ac-d1"), (Some(0.05 * 0.2), Some(0.0)));
    assert_eq!(friction("ac-d2"), (Some(0.002), Some(0.0)));
    assert_eq!(friction("ac-b2"), (Some(0.003), Some(4e-6)));
    assert_eq!(friction("ac-b3"), (Some(0.0), Some(0.05 * 2.0 / 460.0)));
    assert_eq!(friction("ac-b4"), (Some(0.0), Some(0.0)));
    assert_eq!(friction("ac-d3"), (Some(0.05 * 2.0), Some(0.0)));
    assert_eq!(friction("ac-b5"), (Some(0.0), None));
    assert_eq!(friction("ac-d4"), (None, Some(0.0)));
    // A derived no-load current is no printed one.
    assert_eq!(motor(&catalog, "ac-b3").sheet.no_load_current, None);
    let assumed = remarks(&result, "assumed", "acme_motors.csv");
    for (line, key, code) in [
        (2, "AC_B1", "coulomb-friction-zero"),
        (2, "AC_B1", "viscous-friction-from-no-load"),
        (2, "AC_B1", "infinite-is-unknown"),
        (2, "AC_B1", "no-gear-listed"),
        (3, "AC_D1", "coulomb-friction-from-no-load"),
        (4, "AC_D2", "viscous-friction-zero"),
        (6, "AC_B3", "no-load-current-derived"),
        (7, "AC_B4", "no-load-current-negative"),
        (9, "AC_B5", "friction-unknown"),
        (10, "AC_D4", "friction-unknown"),
    ] {
        assert!(has(&assumed, line, key, code), "{line} {key} {code}: {assumed:?}");
    }
    assert!(!assumed.iter().any(|(line, _, code)| *line == 5 && code.contains("friction")));
    assert!(has(&remarks(&result, "left_out", "acme_motors.csv"), 2, "AC_B1", "no-column"));
    assert_eq!(gear(&catalog, "direct").fits("ac-b1"), Some(true));
}

#[test]
fn refused_rows_are_listed_with_line_and_reason() {
    let good = format!("AC_1,Acme,one,BLDC,{REST},,,,");
    let rows = [
        good.clone(),
        "AC_2,Acme,two,BLDC,24,0.05,,,,,,,,,,,,,,,".into(),
        "AC_3,Acme,three,BLDC,24,0.05,NaN,,,,,,,,,,,,,,".into(),
        "AC_4,Acme,four,BLDC,24,0.05,-0.5,,,,,,,,,,,,,,".into(),
        "AC_5,Acme,five,BLDC,24,inf,0.5,,,,,,,,,,,,,,".into(),
        "AC_6,Acme,six,BLDC,24,0.05,0.5,0.85-3,0,,,,,,,,,,,,".into(),
        good,
        "AC_7,Acme,seven,stepper,24,0.05,0.5,,,,,,,,,,,,,,".into(),
        format!(",Acme,eight,BLDC,{REST},,,,"),
        "AC_9,Acme,nine,BLDC,24".into(),
        format!("AC-1,Acme,ten,BLDC,{REST},,,,"),
    ];
    let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
    let gears = [
        "AC_G1,Acme,g1,planetary,2,20,0.1,1e-7,0.8,1,inf,2",
        "AC_G2,Acme,g2,planetary,2,0,0.1,1e-7,0.8,1,3,2",
        "AC_G3,Acme,g3,gizmo,2,20,0.1,1e-7,0.8,1,3,2",
        "AC_G4,Acme,g4,spur,2,20,0.1,1e-7,80,1,3,2",
        "AC_G5,Acme,g5,spur,2.5,20,0.1,1e-7,0.8,7,3,2",
        "AC_G1,Acme,g6,spur,2,20,0.1,1e-7,0.8,1,3,2",
    ];
    let fits = "AC_1,AC_G1,AC_G2,AC_G9,AC_X*,\nAC_2,AC_G1\nAC_8,AC_G1,AC_G1\n\n";
    let database = Database::new(&[
        ("Acme/acme_motors.csv", lines(MOTORS, &rows)),
        ("Acme/acme_gearboxes.csv", lines(GEARS, &gears)),
        ("Acme/acme_compatibility.csv", fits.into()),
        ("Acme/prices.csv", "key,price\n".into()),
    ]);
    let result = database.json(&[]);
    let at = |line: u64, key: &str, code: &str| (line, key.to_string(), code.to_string());
    assert_eq!(
        remarks(&result, "refused", "acme_motors.csv"),
        [
            at(3, "AC_2", "missing-resistance"),
            at(4, "AC_3", "missing-resistance"),
            at(5, "AC_4", "value-out-of-range"),
            at(6, "AC_5", "missing-torque-constant"),
            at(7, "AC_6", "not-a-number"),
            at(8, "AC_1", "duplicate-key"),
            at(9, "AC_7", "unknown-type"),
            at(10, "", "missing-key"),
            at(11, "", "unreadable-row"),
        ]
    );
    let because = |line: u64| {
        let all = result["refused"].as_array().unwrap();
        let found = all.iter().find(|r| r["line"] == line && r["file"].as_str().unwrap().ends_with("motors.csv"));
        found.unwrap()["because"].as_str().unwrap().to_string()
    };
    assert!(because(7).contains("`0.85-3` is not a number") && because(7).contains("mass is 0"), "{}", because(7));
    assert!(because(8).contains("acme_motors.csv:2"), "{}", because(8));
    assert_eq!(
        remarks(&result, "refused", "acme_gearboxes.csv"),
        [
            at(3, "AC_G2", "value-out-of-range"),
            at(4, "AC_G3", "unknown-type"),
            at(5, "AC_G4", "value-out-of-range"),
            at(6, "AC_G5", "value-out-of-range"),
            at(7, "AC_G1", "duplicate-key"),
        ]
    );
    assert_eq!(
        remarks(&result, "refused", "acme_compatibility.csv"),
        [
            at(1, "AC_1", "names-no-gear"),
            at(1, "AC_1", "names-no-gear"),
            at(1, "AC_1", "names-no-gear"),
            at(2, "AC_2", "names-no-motor"),
            at(3, "AC_8", "names-no-motor"),
        ]
    );
    let entries: Vec<&str> =
        result["refused"].as_array().unwrap().iter().map(|r| r["because"].as_str().unwrap()).collect();
    for expected in ["`AC_G2` names a gear whose row was refused", "`AC_G9` names no gear", "`AC_X*` names no gear"] {
        assert!(entries.iter().any(|e| e.contains(expected)), "{expected}: {entries:?}");
    }
    assert!(has(&remarks(&result, "left_out", "prices.csv"), 1, "", "file-not-read"));
    // Two keys that would share an id.
    assert!(has(&remarks(&result, "assumed", "acme_motors.csv"), 12, "AC-1", "id-numbered"));
    let catalog = database.catalog();
    let ids: Vec<&str> = catalog.motors.iter().map(|m| m.id.as_str()).collect();
    assert_eq!(ids, ["ac-1", "ac-1-2"]);
    assert_eq!(gear(&catalog, "ac-g1").fits, ["ac-1"]);
    assert_eq!((&result["files"][1]["rows"], &result["files"][1]["refused"]), (&11.into(), &9.into()));
    // The table lists what was refused, and the assumptions row by row on demand.
    let text = |more: &[&str]| String::from_utf8(database.import(&[&["--force"], more].concat()).stdout).unwrap();
    assert!(text(&[]).contains("acme_motors.csv:4:") && text(&[]).contains("Refused: 19"), "{}", text(&[]));
    let assumed = result["assumed"].as_array().unwrap().len();
    assert!(text(&["--rows"]).matches("acme_").count() > assumed);
    let csv = text(&["--csv"]);
    assert_eq!(csv.lines().filter(|l| l.starts_with("refused,")).count(), 19);
    assert_eq!(csv.lines().filter(|l| l.starts_with("taken,")).count(), 4);
}

#[test]
fn gears_fit_the_motors_that_list_them_wildcards_too() {
    let motors: Vec<String> = ["22W012", "22W024", "22W048", "32G024", "32G048"]
        .iter()
        .map(|id| format!("AC_{id},Acme,\"={id}, \"\"new\"\"\",DC,{REST},,,,"))
        .collect();
    let motors: Vec<&str> = motors.iter().map(String::as_str).collect();
    let gears = [
        "AC_26_R3.6:1,Acme,26 3.6:1,planetary,NaN,3.6,0.1,0,,-1.0,3,4",
        "AC_26_R11:1,Acme,26 11:1,Koaxdrive,2,11,0.1,1e-7,0.8,1,inf,2",
        "AC_32_R5:1,Acme,32 5:1,strain wave,1,5,0.1,1e-7,0.8,1,3,2",
        "AC_40_R5:1,,40 5:1,planetary,1,5,0.1,1e-7,0.8,1,3,2",
    ];
    let fits = "AC_22W*,AC_26_R*\r\nAC_32G024, AC_26_R11:1 ,AC_32_R*\r\nAC_22W012,AC_32_R5:1\r\n";
    let database = Database::new(&[
        ("Acme/acme_motors.csv", lines(MOTORS, &motors).replace('\n', "\r\n")),
        ("Acme/acme_gearboxes.csv", format!("\u{feff}{}", lines(GEARS, &gears))),
        ("Acme/acme_compatibility.csv", fits.into()),
    ]);
    let result = database.json(&[]);
    assert_eq!(result["compatible_pairs"], 3 + 3 + 1 + 1 + 1);
    assert!(result["refused"].as_array().unwrap().is_empty(), "{}", result["refused"]);
    let catalog = database.catalog();
    assert_eq!(gear(&catalog, "ac-26-r3.6-1").fits, ["ac-22*"]);
    assert_eq!(gear(&catalog, "ac-26-r11-1").fits, ["ac-22*", "ac-32g024"]);
    assert_eq!(gear(&catalog, "ac-32-r5-1").fits, ["ac-22w012", "ac-32g024"]);
    // Nobody lists it, so it fits nobody: a blank would let it fit all.
    assert!(catalog.motors.iter().all(|m| gear(&catalog, "ac-40-r5-1").fits(&m.id) == Some(false)));
    assert!(catalog.motors.iter().all(|m| gear(&catalog, "direct").fits(&m.id) == Some(true)));
    let first = gear(&catalog, "ac-26-r3.6-1");
    assert_eq!((first.efficiency, first.backdrive_efficiency, first.stages), (Some(1.0), Some(1.0), None));
    assert_eq!((first.peak_torque, first.continuous_torque, first.inertia), (Some(3.0), Some(3.0), Some(0.0)));
    let second = gear(&catalog, "ac-26-r11-1");
    assert_eq!(
        (second.kind, second.efficiency, second.backdrive_efficiency),
        (GearKind::Planetary, Some(0.8), Some(0.8))
    );
    assert_eq!((second.peak_torque, second.continuous_torque), (None, Some(2.0)));
    assert_eq!(gear(&catalog, "ac-32-r5-1").kind, GearKind::StrainWave);
    let direct = gear(&catalog, "direct");
    assert_eq!((direct.kind, direct.ratio, direct.mass, direct.inertia), (GearKind::Direct, 1.0, Some(0.0), Some(0.0)));
    assert_eq!((direct.efficiency, direct.backdrive_efficiency), (Some(1.0), Some(1.0)));
    // Cells are safe: a formula is text, commas and quotes stay where they are.
    assert!(database.written().values().any(|text| text.contains(",\"'=22W012")));
    assert_eq!(motor(&catalog, "ac-22w012").model, "=22W012, \"new\"");
    let assumed = remarks(&result, "assumed", "acme_gearboxes.csv");
    for (line, key, code) in [
        (2, "AC_26_R3.6:1", "gear-lossless"),
        (2, "AC_26_R3.6:1", "gear-zero"),
        (2, "AC_26_R3.6:1", "direction-reversed"),
        (2, "AC_26_R3.6:1", "continuous-torque-lowered"),
        (3, "AC_26_R11:1", "koaxdrive-planetary"),
        (5, "AC_40_R5:1", "no-motor-listed"),
        (5, "AC_40_R5:1", "maker-from-folder"),
    ] {
        assert!(has(&assumed, line, key, code), "{line} {key} {code}: {assumed:?}");
    }
}

#[test]
fn files_are_written_whole_or_not_at_all() {
    let row = format!("AC_1,Acme,one,BLDC,{REST},,,,");
    let database = Database::new(&[("acme_motors.csv", lines(MOTORS, &[&row]))]);
    let first = database.json(&[]);
    let before = database.written();
    assert_eq!(before.len(), 2, "{:?}", before.keys());
    let again = database.import(&[]);
    assert_eq!(again.status.code(), Some(2));
    assert!(
        stderr(&again).contains("mgdb-acme.csv`") && stderr(&again).contains("`--force` replaces"),
        "{}",
        stderr(&again)
    );
    assert_eq!(database.json(&["--force"]), first, "the same input gives the same output");
    assert_eq!(database.written(), before);
    // The second file cannot be written: the first stays what it was.
    fs::write(database.path("db").join("acme_motors.csv"), lines(MOTORS, &[&row.replace("0.05", "0.06")])).unwrap();
    let direct = database.path("out/gears/mgdb-direct.csv");
    let text = fs::read_to_string(&direct).unwrap();
    fs::remove_file(&direct).unwrap();
    fs::create_dir(&direct).unwrap();
    let failed = database.import(&["--force"]);
    assert_eq!(failed.status.code(), Some(2));
    assert!(stderr(&failed).contains("nothing was written"), "{}", stderr(&failed));
    fs::remove_dir(&direct).unwrap();
    fs::write(&direct, text).unwrap();
    assert_eq!(database.written(), before);
    assert_eq!(database.import(&["--force"]).status.code(), Some(0));
    assert_eq!(database.written().len(), 2, "no temporary file is left");
    assert_eq!(motor(&database.catalog(), "ac-1").torque_constant, 0.06);
}

#[test]
fn what_is_no_database_is_one_error() {
    let row = format!("AC_1,Acme,one,BLDC,{REST},,,,");
    let missing = Database::new(&[]);
    let empty = Database::new(&[("notes.txt", "nothing".into())]);
    let only_fits = Database::new(&[("acme_compatibility.csv", "AC_1,AC_2\n".into())]);
    let no_column = Database::new(&[("acme_motors.csv", lines(&MOTORS.replace(",R,", ",Ohm,"), &[&row]))]);
    let twice = Database::new(&[("acme_motors.csv", lines(&MOTORS.replace(",L,", ",R,"), &[&row]))]);
    let nothing = Database::new(&[("acme_motors.csv", lines(MOTORS, &[&row.replace("BLDC", "AC")]))]);
    let no_text = Database::new(&[("acme_motors.csv", String::new())]);
    for (database, expected) in [
        (&missing, "there is no such folder"),
        (&empty, "there is no file of the Motor-Gearbox Database in this folder"),
        (&only_fits, "there is no file of the Motor-Gearbox Database in this folder"),
        (&no_column, "column `R` is missing"),
        (&twice, "duplicate column `R`"),
        (&nothing, "type is `AC`: expected BLDC or DC"),
        (&no_text, "the file is empty"),
    ] {
        let output = database.import(&[]);
        assert_eq!(output.status.code(), Some(2), "{expected}");
        assert!(stderr(&output).contains(expected), "{expected}: {}", stderr(&output));
        assert!(stderr(&output).contains("1 mistake in 1 file"), "{expected}: {}", stderr(&output));
        assert!(output.stdout.is_empty() && !database.path("out").exists(), "{expected}");
    }
    let file = import(&repository("README.md"), &empty.path("out"), &[]);
    assert!(
        file.status.code() == Some(2) && stderr(&file).contains("this is a file, not a folder"),
        "{}",
        stderr(&file)
    );
    let unknown =
        Command::new(env!("CARGO_BIN_EXE_gearwise")).args(["import", "mgbd", "x", "--out", "y"]).output().unwrap();
    assert!(
        unknown.status.code() == Some(2) && stderr(&unknown).contains("possible values: mgdb"),
        "{}",
        stderr(&unknown)
    );
    // A column too many is no mistake, but it is said.
    let more = Database::new(&[("acme_motors.csv", lines(&MOTORS.replace(",I_nom,", ",I_nomi,"), &[&row]))]);
    let result = more.json(&[]);
    assert!(has(&remarks(&result, "left_out", "acme_motors.csv"), 1, "", "unknown-column"), "{result}");
    assert!(result["left_out"].to_string().contains("is it `I_nom`?"), "{}", result["left_out"]);
}

/// The loss sum R I² of one actuator along the motion of CORDS' `joule_rigid`, after the formulae of
/// `joule_rigid.json`: viscous and Coulomb friction and the rotor at the motor, the gear's efficiency
/// both ways. \[A²·Ω\]
fn joule(motor: &Motor, gear: &Gear, motion: &[[f64; 3]]) -> f64 {
    let (n, eta, back) = (gear.ratio, gear.efficiency.unwrap(), gear.backdrive_efficiency.unwrap());
    let sample = |[speed, acceleration, torque]: &[f64; 3]| {
        let out = torque + gear.inertia.unwrap() * n * n * acceleration;
        let at_motor = if out * speed >= 0.0 { out / (n * eta) } else { out * back / n };
        let friction = motor.coulomb_friction.unwrap() * speed.signum() + motor.viscous_friction.unwrap() * n * speed;
        let torque = at_motor + friction + motor.rotor_inertia.unwrap() * n * acceleration;
        motor.resistance * (torque / motor.torque_constant).powi(2)
    };
    motion.iter().map(sample).sum()
}

#[test]
fn the_real_database() {
    let Some(shared) = crate::common::shared().filter(|shared| shared.join("mgdb").is_dir()) else {
        println!("not run: GEARWISE_SHARED names no folder with mgdb");
        return;
    };
    let database = Database::new(&[]);
    let output = import(&shared.join("mgdb"), &database.path("out"), &["--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let result: Value = serde_json::from_slice(&output.stdout).unwrap();
    let catalog = database.catalog();
    assert_eq!((catalog.motors.len(), catalog.gears.len()), (1036, 2543 + 1));
    assert_eq!(result["compatible_pairs"], 84_791);
    let refused = result["refused"].as_array().unwrap();
    assert_eq!(refused.len(), 1);
    assert_eq!(refused[0]["key"], "AM_HT01002-A00");
    assert!(refused[0]["because"].as_str().unwrap().contains("`0.85-3` is not a number"));
    // What the catalogue's patterns say is what the database lists.
    let fitting = |g: &Gear| catalog.motors.iter().filter(|m| g.fits(&m.id) == Some(true)).count();
    let pairs: usize = catalog.gears.iter().map(fitting).sum();
    assert_eq!(pairs, 84_791 + 1036);
    let count = |code: &str| result["assumed"].as_array().unwrap().iter().filter(|r| r["code"] == code).count();
    for (code, expected) in [
        ("gear-lossless", 31),
        ("direction-reversed", 49),
        ("continuous-torque-lowered", 12),
        ("koaxdrive-planetary", 24),
        ("coulomb-friction-from-no-load", 302),
        ("viscous-friction-zero", 463),
        ("coulomb-friction-zero", 505),
        ("viscous-friction-from-no-load", 505),
        ("no-load-current-negative", 7),
        ("friction-unknown", 0),
    ] {
        assert_eq!(count(code), expected, "{code}");
    }
    let motor_574741 = motor(&catalog, "mm-574741");
    assert_eq!(motor_574741.continuous_current, Some(8.96));
    assert_eq!((motor_574741.torque_constant, motor_574741.resistance), (0.0481, 0.0948));
    assert_eq!((motor_574741.coulomb_friction, motor_574741.thermal_resistance), (Some(0.0), Some(0.63 + 4.32)));
    assert_relative_eq!(motor_574741.viscous_friction.unwrap(), 0.0481 * 0.716 / 494.277_244_164_794);
    let gear_223094 = gear(&catalog, "mm-223094");
    assert_eq!((gear_223094.ratio, gear_223094.efficiency), (91.0, Some(0.75)));
    assert_eq!((gear_223094.continuous_torque, gear_223094.peak_torque), (Some(30.0), Some(45.0)));
    assert_relative_eq!(motor_574741.mass.unwrap() + gear_223094.mass.unwrap(), 1.59, max_relative = 1e-12);
    assert_eq!(gear_223094.fits("mm-574741"), Some(true));
    let ak = motor(&catalog, "tm-ak-60-6");
    assert_eq!((ak.torque_constant, ak.back_emf_constant, ak.peak_torque), (0.068, 0.067, Some(1.66)));
    assert_eq!((ak.sheet.outer_diameter.unwrap().value, ak.sheet.length.unwrap().value), (0.076, 0.0365));

    // CORDS' best ten, and every pair that it finds feasible, cost what they cost there.
    let cases = shared.join("cases/cords");
    let records =
        |file: &str| csv::Reader::from_path(cases.join(file)).unwrap().into_records().map(Result::unwrap).collect();
    let motion: Vec<csv::StringRecord> = records("arm_trajectory.csv");
    let number = |record: &csv::StringRecord, i: usize| record[i].parse::<f64>().unwrap();
    let motion: Vec<[f64; 3]> = motion.iter().map(|r| [number(r, 3), number(r, 4), number(r, 5)]).collect();
    let feasible: Vec<csv::StringRecord> = records("joule_rigid_exact.csv");
    assert_eq!(feasible.len(), 1312);
    let gears: HashMap<&str, &Gear> = catalog.gears.iter().map(|g| (g.id.as_str(), g)).collect();
    for record in &feasible {
        let id = |key: &str| key.to_lowercase().replace(['_', ':'], "-");
        let (motor, gear) =
            (motor(&catalog, &id(&record[0])), if &record[1] == "DD" { "direct".into() } else { id(&record[1]) });
        let gear = gears[gear.as_str()];
        assert_eq!(gear.fits(&motor.id), Some(true), "{} {}", motor.id, gear.id);
        assert_relative_eq!(joule(motor, gear, &motion), number(record, 4), max_relative = 1e-6);
    }
}
