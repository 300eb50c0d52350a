//! What `optimize --write-design` writes passes `check` with the same rules: of random joints, with free ratios and gears, with
//! springs, and with rules of one's own.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};
use serde_json::Value;

use crate::common::repository;

fn run(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_gearwise")).args(arguments).current_dir(folder).output().unwrap()
}

/// Rules with a bound on a measure: of gearwise, and one's own.
fn is_bound(code: &str) -> bool {
    ["GW101", "GW102", "GW103", "GW104", "GW105", "GW106", "GW107", "GW108", "GW109"].contains(&code)
        || !code.starts_with("GW")
}

const RULES: &str = "
[[rule]]
rule = \"voltage-headroom\"
min = 0.3
reason = \"the battery sags\"
[[rule]]
name = \"cool\"
measure = \"continuous_current_margin\"
min = 0.25
severity = \"error\"
reason = \"a closed housing\"
[[rule]]
name = \"light\"
measure = \"mass\"
max = \"1.5 kg\"
severity = \"error\"
reason = \"a leg\"
[[rule]]
name = \"quiet\"
measure = \"loss\"
max = \"20 W\"
severity = \"error\"
reason = \"no limit of the model bounds it: looked at on the result\"
";

#[test]
#[ignore = "long: `.ci/cases` runs it"]
fn what_is_written_passes_its_rules() {
    let mut generator = Pcg64::seed_from_u64(1806);
    let mut random = move || (generator.next_u64() >> 11) as f64 * 2.0_f64.powi(-53);
    let (mut written, mut tightened, mut built) = (0, 0, 0);
    for round in 0..16 {
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path();
        let mut between = |low: f64, high: f64| low * (high / low).powf(random());
        let (torque, speed) = (between(2.0, 50.0), between(2.0, 15.0));
        let geared = round % 4 == 1;
        let ratio = if geared {
            "gears = [\"planetary-*\", \"strain-wave-*\"]".to_string()
        } else {
            "ratio = { min = 3, max = 100 }\ngear = { efficiency = 0.9, mass = \"200 g\", inertia = \"5e-6 kg*m^2\" }"
                .into()
        };
        // A swing whose torque goes with the angle, for the spring.
        let mut motion = String::from("time [s], torque [N*m], velocity [rad/s], position [rad]\n");
        for k in 0..=40 {
            let (t, w) = (f64::from(k) / 40.0, std::f64::consts::TAU);
            let (q, v) = (speed / w * (w * t).sin(), speed * (w * t).cos());
            motion.push_str(&format!("{t},{},{v},{q}\n", torque * (w * t).sin() + 0.1 * torque * (w * t).cos()));
        }
        fs::write(at.join("motion.csv"), motion).unwrap();
        let spring = match round % 8 {
            2 => format!(
                "spring = {{ stiffness = [\"0 N*m/rad\", \"{} N*m/rad\"], rest_angle = [\"-10 deg\", \"10 deg\"] }}\n",
                torque
            ),
            _ => String::new(),
        };
        // Every fourth joint has the swing and a harder one as load cases.
        let (motion, cases) = match round % 4 {
            3 => (
                "",
                "[[joint.case]]\nname = \"swing\"\nmotion = \"motion.csv\"\nshare = 0.9\n[[joint.case]]\nname = \"hard\"\n\
                 motion = \"motion.csv\"\nshare = 0.1\nscale = { torque = 1.6, speed = 1.2 }\n",
            ),
            _ => ("motion = \"motion.csv\"\nperiodic = true\n", ""),
        };
        let text = format!(
            "name = \"robot\"\n[bus]\nvoltage = \"48 V\"\ndrive_current = \"60 A\"\n[[joint]]\nname = \"joint\"\nmotor_drag = \"off\"\n{ratio}\n\
             {motion}[joint.limits]\nsafety = 1.1\n{spring}{cases}"
        );
        fs::write(at.join("robot.toml"), text).unwrap();
        fs::write(at.join("rules.toml"), RULES).unwrap();
        let own = round % 2 == 1;
        let mut arguments = vec!["optimize", "robot.toml", "--write-design", "design.toml", "--only-top", "40"];
        if own {
            arguments.extend(["--rules", "rules.toml"]);
        }
        let output = run(at, &arguments);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        let printed = String::from_utf8_lossy(&output.stdout).into_owned();
        tightened += usize::from(printed.contains("the rules cost"));
        if !at.join("design.toml").exists() {
            assert!(said.contains("no design written: "), "{round}: {said}");
            continue;
        }
        written += 1;
        let design = fs::read_to_string(at.join("design.toml")).unwrap();
        assert_eq!(design.contains("rules = "), own, "{design}");
        built += usize::from(design.contains("planetary: sun"));
        assert!(geared || design.contains("optimal_ratio = "), "{design}");
        let output = run(at, &["check", "design.toml", "--json"]);
        let found: Value = serde_json::from_slice(&output.stdout)
            .unwrap_or_else(|e| panic!("{round}: {e}: {}", String::from_utf8_lossy(&output.stderr)));
        assert_eq!((output.status.code(), &found["passes"]), (Some(0), &Value::Bool(true)), "{round}: {found}");
        for finding in found["findings"].as_array().unwrap() {
            let code = finding["code"].as_str().unwrap();
            let weighs = finding["severity"] != "note";
            assert!(!(weighs && is_bound(code)), "{round}: {finding}\n{design}");
        }
    }
    assert!(written >= 10 && tightened >= 4 && built >= 4, "{written} written, {tightened} tightened, {built} built");
}

/// A rule that is no limit of the program is kept by what is shown first, with a file or without; where nothing keeps it the
/// exit status says so, and a file that was there stays.
#[test]
fn rules_that_are_looked_at_on_the_result_are_kept_too() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let text = "name = \"robot\"\n[bus]\nvoltage = \"48 V\"\n[[joint]]\nname = \"joint\"\nratio = { min = 3, max = 30 }\nmotor_drag = \"off\"\nobjective = \"mass\"\n\
        gear = { efficiency = 0.9, mass = \"200 g\" }\npoints = [ { torque = \"5 N*m\", speed = \"8 rad/s\", duration = \"1 s\" } ]\n";
    fs::write(at.join("robot.toml"), text).unwrap();
    let rule = |most: &str| {
        format!(
            "[[rule]]\nname = \"cool\"\nmeasure = \"copper_loss\"\nmax = \"{most}\"\nseverity = \"error\"\nreason = \"x\"\n"
        )
    };
    let first = |options: &[&str]| {
        let output = run(at, &[&["optimize", "robot.toml", "--json"], options].concat());
        let found: Value = serde_json::from_slice(&output.stdout).unwrap();
        (output.status.code(), found["joints"][0]["candidates"][0].clone(), found["joints"][0]["rejected"].clone())
    };
    fs::write(at.join("rules.toml"), rule("1 W")).unwrap();
    let (_, free, _) = first(&[]);
    let (status, kept, rejected) = first(&["--rules", "rules.toml"]);
    assert!(free["copper_loss_w"].as_f64().unwrap() > 1.0, "{free}");
    assert!(status == Some(0) && kept["copper_loss_w"].as_f64().unwrap() <= 1.0, "{kept}");
    let broken = |r: &&Value| r["because"].as_str().unwrap().contains("a rule is broken: cool");
    assert!(rejected.as_array().unwrap().iter().filter(broken).any(|r| r["motor"] == free["motor"]), "{rejected}");
    let (_, written, _) = first(&["--rules", "rules.toml", "--write-design", "design.toml"]);
    assert_eq!(written["motor"], kept["motor"]);
    let before = fs::read_to_string(at.join("design.toml")).unwrap();
    fs::write(at.join("rules.toml"), rule("1 uW")).unwrap();
    let output = run(at, &["optimize", "robot.toml", "--rules", "rules.toml", "--write-design", "design.toml"]);
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(said.contains("no design written") && said.contains("design.toml is left as it was"), "{said}");
    assert_eq!(fs::read_to_string(at.join("design.toml")).unwrap(), before);
}

/// Two rules of one margin do not add up: the stricter one counts.
#[test]
fn rules_of_one_limit_do_not_add_up() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let text = "name = \"robot\"\n[bus]\nvoltage = \"48 V\"\n[[joint]]\nname = \"joint\"\nratio = { min = 3, max = 60 }\nmotor_drag = \"off\"\nobjective = \"loss\"\n\
        points = [ { torque = \"5 N*m\", speed = \"30 rad/s\", duration = \"1 s\" } ]\n";
    fs::write(at.join("robot.toml"), text).unwrap();
    let rule = |name: &str| {
        format!(
            "[[rule]]\nname = \"{name}\"\nmeasure = \"voltage_margin\"\nmin = 0.3\nseverity = \"error\"\nreason = \"x\"\n"
        )
    };
    let ratio = |rules: String| {
        fs::write(at.join("rules.toml"), rules).unwrap();
        let output = run(at, &["optimize", "robot.toml", "--json", "--rules", "rules.toml"]);
        let found: Value = serde_json::from_slice(&output.stdout).unwrap();
        let first = found["joints"][0]["candidates"][0].clone();
        (first["motor"].clone(), first["ratio"].as_f64().unwrap())
    };
    let one = ratio(rule("a"));
    assert_eq!(one, ratio(rule("a") + &rule("b")));
    // The voltage of the choice is used to 70 % and no less.
    let (motor, n) = one;
    let design = format!("{}@{n}", motor.as_str().unwrap());
    let output = run(at, &["explain", &design, "robot.toml", "--json"]);
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    let margin = found["joints"][0]["design"]["margins"]["voltage"].as_f64().unwrap();
    assert!((margin - 0.3).abs() < 1e-6, "{margin}");
}

/// Without rules the optimum may lie on a limit, and the check says so: what the rules are there for.
#[test]
fn without_rules_the_optimum_may_break_them() {
    let folder = tempfile::tempdir().unwrap();
    let robot = repository("requirements/arm_six_axis_pick_and_place.toml");
    let robot = robot.to_str().unwrap();
    let design = folder.path().join("design.toml");
    let design = design.to_str().unwrap();
    let here = repository("");
    let warnings = |options: &[&str]| {
        // Without the motors' drag the best ratios of an arm lie on voltage.
        let words = ["optimize", robot, "--set", "joint.*.motor_drag=off", "--write-design", design];
        let output = run(&here, &[&words, options].concat());
        assert_eq!(output.status.code(), Some(0));
        let found: Value = serde_json::from_slice(&run(&here, &["check", design, "--json"]).stdout).unwrap();
        let all = found["findings"].as_array().unwrap();
        all.iter().filter(|f| f["severity"] != "note" && is_bound(f["code"].as_str().unwrap())).count()
    };
    assert!(warnings(&["--no-rules"]) > 0);
    assert_eq!(warnings(&[]), 0);
}

/// For a whole robot, the answer names the combination that is written instead of the best one, and the rule that rejects the best.
#[test]
fn another_combination_is_named_before_it_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let design = folder.path().join("design.toml");
    let words = ["optimize", "requirements/quadruped_mini_cheetah.toml", "--robot"];
    let text = |more: &[&str]| String::from_utf8(run(&repository(""), &[&words, more].concat()).stdout).unwrap();
    let line = |text: &str| {
        let flat = text.split_whitespace().collect::<Vec<_>>().join(" ");
        let from = flat.find("`--write-design` would write another combination (")?;
        flat[from..].find("). ").or(flat[from..].find(");")).map(|to| flat[from..from + to].to_string())
    };
    let said = line(&text(&[])).unwrap();
    assert_eq!(line(&text(&["--write-design", design.to_str().unwrap()])), None);
    let written = fs::read_to_string(&design).unwrap();
    let motors: Vec<&str> = written.lines().filter_map(|l| l.strip_prefix("motor = \"")?.strip_suffix('"')).collect();
    let named = said.split(", ").filter_map(|part| part.split_once(": ")?.1.split(' ').next()).collect::<Vec<_>>();
    assert!(!named.is_empty() && named.iter().all(|motor| motors.contains(motor)), "{said}\n{written}");
}

#[test]
fn a_rules_file_of_the_requirement_is_kept_and_its_mistakes_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let text = "name = \"robot\"\nrules = \"rules.toml\"\n[bus]\nvoltage = \"48 V\"\n[[joint]]\nname = \"joint\"\nmotor_drag = \"off\"\nratio = { min = 3, max = 30 }\n\
        points = [ { torque = \"5 N*m\", speed = \"40 rad/s\", duration = \"1 s\" } ]\n";
    fs::write(at.join("robot.toml"), text).unwrap();
    fs::write(at.join("rules.toml"), RULES).unwrap();
    let ratio = |options: &[&str]| {
        let output = run(at, &[&["optimize", "robot.toml", "--json"], options].concat());
        let found: Value = serde_json::from_slice(&output.stdout).unwrap();
        let first = found["joints"][0]["candidates"][0].clone();
        (first["ratio"].as_f64().unwrap(), first["loss_w"].as_f64().unwrap())
    };
    let (with, without) = (ratio(&[]), ratio(&["--no-rules"]));
    assert!(with.1 >= without.1 && with != without, "{with:?} {without:?}");
    fs::write(at.join("rules.toml"), RULES.replace("min = 0.3\n", "min = \"abc\"\n")).unwrap();
    let output = run(at, &["optimize", "robot.toml"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("rules.toml"));
    let output = run(at, &["optimize", "robot.toml", "--rules", "nothing.toml"]);
    assert_eq!(output.status.code(), Some(2));
    // A share of one or more leaves nothing.
    fs::write(
        at.join("robot.toml"),
        format!("{text}limits = {{ reserve = {{ voltage = 1.5 }} }}\n").replace("rules = \"rules.toml\"\n", ""),
    )
    .unwrap();
    let output = run(at, &["optimize", "robot.toml"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(2) && said.contains("voltage") && said.contains("less than 1"), "{said}");
}

/// A ratio is compared with the best one under the same rules: what a rule asks for, another does not advise against.
#[test]
fn a_ratio_that_a_rule_asks_for_is_not_called_far_from_the_best() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let text = "name = \"robot\"\n[bus]\nvoltage = \"48 V\"\n[[joint]]\nname = \"joint\"\nratio = { min = 3, max = 30 }\nmotor_drag = \"off\"\nobjective = \"loss\"\n\
        gear = { efficiency = 0.9, mass = \"200 g\" }\npoints = [ { torque = \"5 N*m\", speed = \"4 rad/s\", duration = \"1 s\" } ]\n";
    fs::write(at.join("robot.toml"), text).unwrap();
    let rule =
        "[[rule]]\nname = \"low\"\nmeasure = \"ratio\"\nmax = 6\nseverity = \"error\"\nreason = \"backdrivable\"\n";
    fs::write(at.join("rules.toml"), rule).unwrap();
    let output = run(at, &["optimize", "robot.toml", "--rules", "rules.toml", "--write-design", "design.toml"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let design = fs::read_to_string(at.join("design.toml")).unwrap();
    let free: String = design.lines().filter(|l| !l.starts_with("rules = ")).map(|l| format!("{l}\n")).collect();
    fs::write(at.join("free.toml"), free).unwrap();
    let far = |design: &str| {
        let output = run(at, &["check", design, "--json"]);
        let found: Value = serde_json::from_slice(&output.stdout).unwrap();
        found["findings"].as_array().unwrap().iter().any(|f| f["code"] == "GW111")
    };
    assert!(!far("design.toml"), "{design}");
    assert!(far("free.toml"), "without the rule it is far from the best: {design}");
}
