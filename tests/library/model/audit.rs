//! The audit on sheets that are known to be wrong, known to be right, and on the shipped catalogue.

use gearwise::catalog::audit::{Finding, Severity, audit, audit_motor};
use gearwise::catalog::{Catalog, SourceKind};

use crate::common::{self, motor, repository};

fn codes(findings: &[Finding]) -> Vec<&str> {
    findings.iter().filter(|f| f.severity == Severity::Error).map(|f| f.code).collect()
}

#[test]
fn the_four_inconsistencies_of_the_paper_are_found() {
    let catalog = Catalog::read(&[repository("tests/fixtures/paper_motors.csv")]).unwrap();
    let findings = audit(&catalog);
    let of = |id: &str, code: &str| {
        findings.iter().find(|f| f.id == id && f.code == code).unwrap_or_else(|| panic!("{code} of {id} was not found"))
    };
    // 1. Inductance headed µH for 2.559 where the text has 2559 µH.
    let inductance = of("ri50-table", "inductance-unit");
    assert!(inductance.explanation.as_ref().unwrap().contains("µH for mH"), "{inductance:?}");
    of("u8-table", "inductance-unit");
    assert!(!findings.iter().any(|f| f.id == "ri50-text" && f.code == "inductance-unit"));
    // 2. S_M 0.644 ms from the paper's own numbers, printed 0.67.
    let s_m = of("ri50-text", "responsiveness");
    assert!(s_m.message.contains("0.67") && s_m.message.contains("0.6436"), "{s_m:?}");
    // 3. The U8's K_M is 0.265, printed 0.23; and the printed S_M follows from the printed K_M.
    let k_m = of("u8-table", "motor-constant");
    assert!(k_m.message.contains("0.23") && k_m.message.contains("0.265"), "{k_m:?}");
    assert!(k_m.explanation.as_ref().unwrap().contains("frames mixed"));
    assert!(of("u8-table", "responsiveness").explanation.as_ref().unwrap().contains("follows from the printed K_M"));
    // 4. The RI50's K_T exceeds its K_B by 11.7 ± 3 %.
    assert!(of("ri50-text", "back-emf").message.contains("11.7 ± 3.2 %"));
    // S_T is printed right.
    assert!(!findings.iter().any(|f| f.code == "torque-specific-inertia"));
}

#[test]
fn sheets_that_add_up_have_no_findings() {
    // maxon EC-4pole 22 90 W, 323218, catalogue March 2021 p. 257, and FAULHABER 4221 BXT H: in the DC frame.
    let maxon = motor(&[
        ("terminals", "line_to_line"),
        ("current", "dc"),
        ("resistance [ohm]", "0.527"),
        ("inductance [uH]", "50.3"),
        ("torque_constant [mN*m/A]", "14.0"),
        ("speed_constant [rpm/V]", "680"),
        ("speed_constant_convention", "dc"),
        ("rotor_inertia [g*cm^2]", "5.54"),
        ("voltage [V]", "24"),
        ("stall_torque [mN*m]", "639"),
        ("no_load_speed [rpm]", "16300"),
        ("no_load_current [A]", "0.164"),
        ("mechanical_time_constant [ms]", "1.48"),
        ("continuous_torque [mN*m]", "45.1"),
        ("continuous_current [A]", "3.34"),
        ("thermal_time_constant_winding [s]", "5.12"),
        ("thermal_time_constant_housing [s]", "482"),
    ]);
    assert!(audit_motor(&maxon).is_empty(), "{:?}", audit_motor(&maxon));
    for (r, k, i0, v, speed, stall, tau) in [
        ("0.46", "0.0298", "0.177", "18", "5710", "1.17", "3.56"),
        ("0.74", "0.0377", "0.139", "24", "6040", "1.22", "3.59"),
        ("2.6", "0.0752", "0.103", "48", "6070", "1.39", "3.18"),
    ] {
        let faulhaber = motor(&[
            ("terminals", "line_to_line"),
            ("current", "dc"),
            ("resistance [ohm]", r),
            ("torque_constant [N*m/A]", k),
            ("rotor_inertia [g*cm^2]", "69"),
            ("voltage [V]", v),
            ("no_load_speed [rpm]", speed),
            ("no_load_current [A]", i0),
            ("stall_torque [N*m]", stall),
            ("mechanical_time_constant [ms]", tau),
        ]);
        assert!(audit_motor(&faulhaber).is_empty(), "{:?}", audit_motor(&faulhaber));
    }
}

#[test]
fn a_wrong_convention_is_named() {
    // An outrunner of Kv 100: 0.0827 N·m per ampere of phase amplitude, 0.117 per rms, declared as q axis.
    let outrunner = |k: &str, current: &str| {
        motor(&[
            ("current", current),
            ("resistance [ohm]", "0.1"),
            ("torque_constant [N*m/A]", k),
            ("speed_constant [rpm/V]", "100"),
            ("speed_constant_convention", "line_to_line_peak"),
        ])
    };
    for (k, right) in [("0.0827", "phase_amplitude"), ("0.117", "rms"), ("0.0912", "dc")] {
        assert!(audit_motor(&outrunner(k, right)).is_empty(), "{k} {right}: {:?}", audit_motor(&outrunner(k, right)));
        let findings = audit_motor(&outrunner(k, "q_axis"));
        assert_eq!(codes(&findings), ["speed-constant"]);
        assert!(findings[0].explanation.as_ref().unwrap().contains(&format!("current = {right}")), "{findings:?}");
    }
}

#[test]
fn other_contradictions_are_found() {
    let base = [("resistance [ohm]", "0.1"), ("torque_constant [N*m/A]", "0.1"), ("rotor_inertia [g*cm^2]", "500")];
    for (code, cells) in [
        ("peak-torque", vec![("peak_torque [N*m]", "2.5"), ("peak_current [A]", "20")]),
        ("continuous-torque", vec![("continuous_torque [N*m]", "5"), ("continuous_current [A]", "10")]),
        ("rotor-inertia", vec![("rotor_mass [g]", "100"), ("gap_radius [mm]", "100")]),
        (
            "thermal-time-constants",
            vec![("thermal_time_constant_winding [s]", "900"), ("thermal_time_constant_housing [s]", "30")],
        ),
        ("mechanical-time-constant", vec![("mechanical_time_constant [ms]", "1")]),
        ("torque-specific-inertia", vec![("torque_specific_inertia [g*(A/N)^2]", "4")]),
        ("stall-torque", vec![("voltage [V]", "24"), ("stall_torque [N*m]", "24")]),
        ("no-load-speed", vec![("voltage [V]", "24"), ("no_load_speed [rpm]", "3000")]),
    ] {
        let motor = motor(&base.iter().copied().chain(cells).collect::<Vec<_>>());
        assert_eq!(codes(&audit_motor(&motor)), [code]);
    }
    // 0.86 of K_T·I is iron saturation: worth a note, not an error.
    let saturated = motor(
        &base.iter().copied().chain([("peak_torque [N*m]", "1.72"), ("peak_current [A]", "20")]).collect::<Vec<_>>(),
    );
    assert!(codes(&audit_motor(&saturated)).is_empty() && audit_motor(&saturated).len() == 1);
}

#[test]
fn an_acceptance_must_fit_a_finding_and_be_explained() {
    let base = [
        ("resistance [ohm]", "0.1"),
        ("torque_constant [N*m/A]", "0.1"),
        ("peak_torque [N*m]", "2.5"),
        ("peak_current [A]", "20"),
    ];
    let with = |cells: &[(&'static str, &'static str)]| {
        motor(&base.iter().copied().chain(cells.iter().copied()).collect::<Vec<_>>())
    };
    let accepted = audit_motor(&with(&[("audit_accept", "peak-torque"), ("note", "measured hot")]));
    assert!(accepted.len() == 1 && accepted[0].accepted);
    assert_eq!(codes(&audit_motor(&with(&[("audit_accept", "peak-torque")]))), ["peak-torque", "accept-without-note"]);
    assert_eq!(
        codes(&audit_motor(&with(&[("audit_accept", "stall-torque"), ("note", "x")]))),
        ["peak-torque", "stale-accept"]
    );
}

#[test]
fn the_shipped_catalogue_is_sound() {
    let catalog = Catalog::builtin().unwrap();
    let broken: Vec<_> = audit(&catalog).into_iter().filter(|f| f.severity == Severity::Error && !f.accepted).collect();
    assert!(broken.is_empty(), "{broken:?}");
    assert!(catalog.motors.len() >= 100 && catalog.gears.len() >= 80);
    let complete =
        catalog.motors.iter().filter(|m| m.inductance.is_some() && m.pole_pairs.is_some_and(|p| p > 0)).count();
    assert!(complete >= 40, "{complete} motors have inductance and pole pairs");
    assert!(catalog.motors.iter().all(|m| !m.source.is_empty()) && catalog.gears.iter().all(|g| !g.source.is_empty()));
    let collected = catalog.motors.iter().filter(|m| m.source.contains("MGDB")).count();
    let gears = catalog.gears.iter().filter(|g| g.source.contains("MGDB")).count();
    assert!(collected <= 100 && gears <= 80, "{collected} motors and {gears} gears take values from MGDB");
    for maker in ["maxon", "FAULHABER", "T-Motor", "Allied Motion", "TQ RoboDrive", "mjbots", "MIT"] {
        assert!(catalog.motors.iter().any(|m| m.manufacturer.contains(maker)), "{maker}");
    }
    assert!(catalog.motors.iter().any(|m| m.source_kind == SourceKind::Measured));
    // Every gear pattern that names a maker's motor is meant for the motors that are shipped.
    let fitting = catalog.gears.iter().filter(|g| catalog.motors.iter().any(|m| g.fits(&m.id) == Some(true))).count();
    assert!(fitting * 10 >= catalog.gears.len() * 9, "{fitting} of {} gears fit a shipped motor", catalog.gears.len());
}

#[test]
fn a_choice_says_that_its_row_contradicts_itself() {
    use gearwise::design::optimize;
    use gearwise::report::json::optimize::json;
    use gearwise::report::optimize::{Shown, text};
    let robot = common::robot(common::hold(2.0, 1.0, 0.0), common::gear(0.9));
    let row = |back_emf: &'static str| {
        motor(&[
            ("resistance [ohm]", "1"),
            ("torque_constant [N*m/A]", "0.1"),
            ("back_emf_constant [V*s/rad]", back_emf),
            ("back_emf_convention", "q_axis"),
            ("rotor_inertia [kg*m^2]", "1e-5"),
        ])
    };
    for (back_emf, wrong) in [("0.05", true), ("0.1", false)] {
        let catalog = Catalog::of(vec![row(back_emf)], Vec::new());
        let result = optimize(&robot, &catalog);
        let shown = text(&result, &[], &[], Shown { top: 5, rejected: false, why: false, full: true });
        assert_eq!(shown.contains("the row contradicts itself"), wrong, "{shown}");
        let errors = json(&result, &[], None)["joints"][0]["candidates"][0]["audit_errors"].as_array().unwrap().len();
        assert_eq!(errors > 0, wrong);
    }
}
