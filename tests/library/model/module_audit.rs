//! The audit of modules against answers that are known: printed numbers of makers, and what they say read one way or another.

use std::sync::Arc;

use gearwise::catalog::audit::{Finding, Severity, audit};
use gearwise::catalog::{Catalog, Module};
use gearwise::input::Source;

/// A catalogue of modules from rows of `(column, cell)`; what every row must have is filled in.
fn modules(rows: &[&[(&str, &str)]]) -> Catalog {
    let mut tables = Vec::new();
    for (k, cells) in rows.iter().enumerate() {
        let (head, row): (Vec<&str>, Vec<&str>) = cells.iter().copied().unzip();
        let text =
            format!("id,drive,source,source_kind,{}\nm{k},built_in,test,derived,{}\n", head.join(","), row.join(","));
        tables.push(Arc::new(Source::new(format!("modules{k}.csv"), text)));
    }
    Catalog::from_sources(tables).unwrap_or_else(|e| panic!("{:?}", e[0].problems))
}

fn found(rows: &[&[(&str, &str)]], code: &str) -> Option<Finding> {
    audit(&modules(rows)).into_iter().find(|f| f.code == code)
}

fn module(id: &str) -> Module {
    Catalog::builtin().unwrap().modules.iter().find(|m| m.id == id).unwrap_or_else(|| panic!("{id}")).clone()
}

fn near(a: f64, b: f64, within: f64) {
    assert!((a - b).abs() <= within, "{a}, expected {b}");
}

#[test]
fn an_armature_at_the_wrong_side_is_named_by_its_factor() {
    let row = |armature: &'static str| {
        vec![
            ("ratio", "9"),
            ("armature [kg*m^2]", armature),
            ("armature_side", "output"),
            ("rotor_inertia [kg*m^2]", "3.4e-4"),
        ]
    };
    // 3.06e-3 is 9 times 3.4e-4, where 81 times is right: nine pairs of one maker's two tables are like this.
    let one = found(&[&row("3.06e-3")], "module-inertia-side").unwrap();
    assert!(one.explanation.unwrap().contains("1/N") && one.severity == Severity::Error);
    assert!(found(&[&row("0.02754")], "module-inertia-side").is_none());
    // A copy with one digit too many or few: 0.1017752 for 0.01017752.
    let shifted = found(&[&row("0.2754")], "module-inertia-side").unwrap();
    assert!(shifted.explanation.unwrap().contains("10^1"));
}

#[test]
fn torque_over_current_tells_how_a_sheet_counts_amperes() {
    // RS00: 5 N·m at 4.7 A, 14 N·m at 15.5 A, 1.48 N·m per A rms; amplitude currents give 1.02 and 0.86.
    let row = |current: &'static str, constant: &'static str| {
        vec![
            ("ratio", "10"),
            ("rated_torque [N*m]", "5"),
            ("peak_torque [N*m]", "14"),
            ("rated_current [A]", "4.7"),
            ("peak_current [A]", "15.5"),
            ("current", current),
            ("torque_constant [N*m/A]", "1.48"),
            ("torque_constant_current", constant),
            ("torque_constant_side", "output"),
            ("torque_constant_loss", "measured"),
        ]
    };
    assert!(found(&[&row("phase_amplitude", "rms")], "module-torque-constant").is_none());
    // Both as amplitudes: too little torque for the current; the reading that fits is named.
    let wrong = found(&[&row("rms", "phase_amplitude")], "module-torque-constant").unwrap();
    assert!(wrong.explanation.unwrap().contains("K_T per rms at the output with currents that are phase_amplitude"));
}

#[test]
fn a_back_emf_constant_tells_the_loss_of_the_gear() {
    near(module("robstride-rs00-module").constants().efficiency.unwrap().0, 0.94, 0.005);
    // 0.096 Vrms/rpm: at the output 0.77; as 9.6 V/krpm at the motor 0.99.
    let row = |emf: &'static str, side: &'static str| {
        vec![
            ("ratio", "7.75"),
            ("torque_constant [N*m/A]", "1.22"),
            ("torque_constant_current", "rms"),
            ("torque_constant_side", "output"),
            ("torque_constant_loss", "measured"),
            ("back_emf_constant [V/rpm]", emf),
            ("back_emf_convention", "line_to_line_rms"),
            ("back_emf_side", side),
        ]
    };
    let efficiency = |emf, side| modules(&[&row(emf, side)]).modules[0].constants().efficiency.unwrap().0;
    near(efficiency("0.096", "output"), 0.77, 0.005);
    near(efficiency("0.0096", "motor"), 0.99, 0.005);
    // The table's number at the motor would make energy.
    let wrong = found(&[&row("0.0047", "motor")], "module-back-emf").unwrap();
    assert_eq!(wrong.severity, Severity::Error);
    // Harmonic Drive, 22 N·m/A and 2.5 V/rpm: several readings give the same efficiency.
    let open = [
        ("ratio", "50"),
        ("torque_constant [N*m/A]", "22"),
        ("torque_constant_current", "dc"),
        ("torque_constant_side", "output"),
        ("torque_constant_loss", "measured"),
        ("back_emf_constant [V/rpm]", "2.5"),
        ("back_emf_convention", "phase_rms"),
        ("back_emf_side", "output"),
    ];
    let cannot_tell = found(&[&open], "module-back-emf").unwrap().explanation.unwrap();
    assert!(cannot_tell.contains("do not separate them"), "{cannot_tell}");
}

#[test]
fn a_speed_that_the_voltage_cannot_make_is_found() {
    let share = |id: &str| {
        let module = module(id);
        let speed = module.sheet.no_load_speed.unwrap().value * module.constants().back_emf_constant.unwrap();
        speed / (module.sheet.voltage.unwrap().value / 2.0_f64.sqrt())
    };
    near(share("damiao-j3507-2ec"), 1.26, 0.005);
    near(share("damiao-j8009-2ec"), 1.07, 0.005);
    for id in ["robstride-rs00-module", "robstride-rs03-module", "robstride-rs04", "robstride-rs06-module"] {
        assert!((0.79..=1.0).contains(&share(id)), "{id}: {}", share(id));
    }
    let all = audit(&Catalog::builtin().unwrap());
    let of = |id: &str| all.iter().find(|f| f.id == id && f.code == "module-no-load-speed");
    assert!(of("damiao-j3507-2ec").is_some() && of("damiao-j8009-2ec").is_some() && of("robstride-rs04").is_none());
}

#[test]
fn a_speed_constant_is_told_by_its_side() {
    let row = |constant: &'static str, side: &'static str| {
        vec![
            ("ratio", "36"),
            ("speed_constant [rpm/V]", constant),
            ("speed_constant_convention", "dc"),
            ("speed_constant_side", side),
            ("voltage [V]", "24"),
            ("no_load_speed [rpm]", "111"),
        ]
    };
    // 12.5 rpm/V is no constant of the motor: at 24 V the flange would turn at 8 rpm.
    assert!(found(&[&row("5", "output")], "module-speed-constant").is_none());
    let other = found(&[&row("5", "motor")], "module-speed-constant").unwrap();
    assert!(other.explanation.unwrap().contains("at the output"));
    let neither = found(&[&row("60", "motor")], "module-speed-constant").unwrap();
    assert!(neither.explanation.is_none());
}

#[test]
fn a_rated_power_is_that_of_a_speed() {
    let row = |power: &'static str, speed: &'static str| {
        vec![
            ("ratio", "7.75"),
            ("rated_torque [N*m]", "6"),
            ("rated_speed [rpm]", speed),
            ("rated_power [W]", power),
            ("rated_power_is", "mechanical"),
        ]
    };
    // RS01: 275 rpm would be 173 W; the printed 60 W is that of 100 rpm (0.35 of it).
    let found_at = found(&[&row("60", "275")], "module-power").unwrap();
    assert!(found_at.message.contains("0.3472") && found_at.severity == Severity::Note, "{}", found_at.message);
    assert!(found_at.explanation.unwrap().contains("95.49 rpm"));
    assert!(found(&[&row("60", "100")], "module-power").is_none());
}

#[test]
fn peak_torques_both_ways_tell_the_loss_of_the_gear() {
    let efficiency = |id: &str| module(id).efficiency_of_braking().unwrap();
    for (id, is) in [
        ("unitree-n7520-14.3", 0.926),
        ("unitree-n5020-16", 0.889),
        ("unitree-n5010-16", 0.779),
        ("unitree-w4010-25", 0.779),
        ("unitree-m107-15", 0.910),
        ("unitree-m107-24", 0.910),
    ] {
        near(efficiency(id), is, 0.001);
    }
    // With 102.8 for 182.8 the gear would make energy.
    let row = [
        ("ratio", "15"),
        ("driving_curve [rad/s : N*m]", "0:150 14:150 25.6:0"),
        ("braking_curve [rad/s : N*m]", "0:102.8 14:102.8 25.6:0"),
    ];
    let wrong = found(&[&row], "module-braking").unwrap();
    assert!(wrong.severity == Severity::Error && wrong.message.contains("1.23"), "{}", wrong.message);
    // Torque over N of one motor in two gears.
    let of = |id: &str| module(id).sheet.peak_torque.unwrap().value / module(id).ratio();
    near(of("unitree-n7520-14.3"), 4.96, 0.005);
    near(of("unitree-n7520-22.5"), 4.93, 0.005);
    near(of("unitree-m107-15"), 10.0, 1e-9);
    near(of("unitree-m107-24"), 10.0, 1e-9);
}

#[test]
fn an_overload_table_bends_as_a_passive_body_does() {
    let row = |table: &'static str| vec![("ratio", "9"), ("rated_torque [N*m]", "20"), ("overload [N*m : s]", table)];
    let wrong = found(&[&row("30:189 40:126 50:12")], "module-overload").unwrap();
    assert!(wrong.severity == Severity::Error, "{}", wrong.message);
    // Times that are rounded bend it a little: no error.
    let rounded = found(&[&row("30:393 40:67 50:34 60:13")], "module-overload");
    assert!(rounded.is_none_or(|f| f.severity == Severity::Note));
    let refused = modules(&[&row("30:189 40:126 50:12")]).with_modules([&"*".to_string()].into_iter(), |m| m);
    assert!(refused.motors[0].inside.as_ref().unwrap().response.is_none());
}

#[test]
fn siblings_that_are_not_alike_are_named() {
    let row = |ratio: &'static str, constant: &'static str| {
        vec![
            ("ratio", ratio),
            ("family", "one"),
            ("torque_constant [N*m/A]", constant),
            ("torque_constant_current", "rms"),
            ("torque_constant_side", "output"),
            ("torque_constant_loss", "measured"),
        ]
    };
    // A second ratio with the constant of the first.
    let alike = found(&[&row("7.75", "0.94"), &row("9", "0.94")], "module-siblings").unwrap();
    assert!(alike.message.contains("K_T/N") && alike.message.contains("m1"), "{}", alike.message);
    assert!(found(&[&row("7.75", "0.94"), &row("9", "1.0916")], "module-siblings").is_none());
}

#[test]
fn a_rated_point_beyond_the_curve_is_found() {
    let row = |speed: &'static str| {
        vec![
            ("ratio", "9"),
            ("rated_torque [N*m]", "10"),
            ("rated_speed [rad/s]", speed),
            ("driving_curve [rad/s : N*m]", "0:20 10:20 20:0"),
        ]
    };
    assert!(found(&[&row("14")], "module-rated-point").is_none());
    assert!(found(&[&row("16")], "module-rated-point").is_some());
}

#[test]
fn the_shipped_modules_are_sound_or_say_why_not() {
    let wrong: Vec<String> = audit(&Catalog::builtin().unwrap())
        .into_iter()
        .filter(|f| f.code.starts_with("module-") || f.code.contains("accept"))
        .filter(|f| f.severity == Severity::Error && !f.accepted)
        .map(|f| format!("{} {}: {}", f.id, f.code, f.message))
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
