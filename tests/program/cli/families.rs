//! Families of gears on the command line: what is said of a point, of a ratio between two, and where a family is looked at.

use std::fs;

use serde_json::Value;

use super::folder::{Ran, folder, run};
use super::tables::collapsed;

const ROBOT: &str = r#"name = "leg"
ambient = { temperature = "25 degC" }
bus = { voltage = "24 V" }
[[joint]]
name = "knee"
family = ["compact-u8-cpg"]
between = true
objective = "loss"
points = [
    { torque = "8 N*m", speed = "5 rad/s", duration = "0.4 s" },
    { torque = "2 N*m", speed = "-12 rad/s", duration = "0.3 s" },
    { torque = "0.5 N*m", speed = "8 rad/s", duration = "0.3 s" },
]
[joint.limits]
winding_temperature = "110 degC"
"#;

fn with(robot: &str, words: &[&str]) -> Ran {
    let folder = folder();
    fs::write(folder.path().join("robot.toml"), robot).unwrap();
    run(&folder, words)
}

const NOBODY: &str = "nobody published this gear";
const LIGHT: &str = "joint.knee.limits.actuator_mass=\"710 g\"";

#[test]
fn what_lies_between_points_is_called_so_and_what_is_at_one_is_not() {
    let between = collapsed(&with(ROBOT, &["optimize", "robot.toml", "--why", "--set", LIGHT]).out);
    assert!(
        between.contains(&format!("between the points compact-u8-cpg-11.41 and compact-u8-cpg-12.12: {NOBODY}")),
        "{between}"
    );
    assert!(
        between.contains("not checked: gear_continuous_torque") && between.contains("not checked: gear_inertia"),
        "{between}"
    );
    assert!(!between.contains("simple planetary near by"), "{between}");
    let at = collapsed(&with(ROBOT, &["optimize", "robot.toml", "--why"]).out);
    assert!(at.contains("at a point of its family: compact-u8-cpg-15.59") && !at.contains(NOBODY), "{at}");
    let points = ROBOT.replace("between = true\n", "");
    let points = collapsed(&with(&points, &["optimize", "robot.toml", "--why", "--set", LIGHT]).out);
    assert!(points.contains("with compact-u8-cpg-11.41") && !points.contains("between the points"), "{points}");
    assert!(points.contains("proved: exact (all gears evaluated)"), "{points}");
    let told = collapsed(&with(ROBOT, &["explain", "t-motor-u8-lee@9", "robot.toml"]).out);
    assert!(told.to_lowercase().contains("between the points compact-u8-cpg-8.273 and compact-u8-cpg-9.171"), "{told}");
}

#[test]
fn machines_are_told_where_a_ratio_lies() {
    let json = |words: &[&str]| -> Value {
        let ran = with(ROBOT, words);
        serde_json::from_str(&ran.out).unwrap_or_else(|e| panic!("{e}: {}{}", ran.out, ran.err))
    };
    let points = |value: &Value| value["joints"][0]["candidates"][0]["family"].clone();
    let between = points(&json(&["optimize", "robot.toml", "--json", "--set", LIGHT]));
    assert_eq!(between["name"], "compact-u8-cpg");
    assert_eq!(between["points"], serde_json::json!(["compact-u8-cpg-11.41", "compact-u8-cpg-12.12"]));
    let at = points(&json(&["optimize", "robot.toml", "--json"]));
    assert_eq!(at["points"], serde_json::json!(["compact-u8-cpg-15.59"]));
}

/// A text with the line that begins so replaced.
fn replaced(text: &str, line: &str, other: &str) -> String {
    let lines = text.lines().map(|l| if l.starts_with(line) { other } else { l });
    lines.collect::<Vec<_>>().join("\n") + "\n"
}

/// What is written is read again, and stands.
#[test]
fn designs_between_points_and_at_one_are_checked() {
    for (set, line) in
        [(LIGHT, "ratio = 11.9294308701633"), ("bus.voltage=\"24 V\"", "gear = \"compact-u8-cpg-15.59\"")]
    {
        let folder = folder();
        fs::write(folder.path().join("robot.toml"), ROBOT).unwrap();
        let ran = run(&folder, &["optimize", "robot.toml", "--set", set, "--write-design", "design.toml"]);
        assert_eq!(ran.status, 0, "{}{}", ran.out, ran.err);
        let text = fs::read_to_string(folder.path().join("design.toml")).unwrap();
        assert!(text.contains(line), "{text}");
        let checked = run(&folder, &["check", "design.toml"]);
        assert_eq!(checked.status, 0, "{}{}", checked.out, checked.err);
        let sent = run(&folder, &["export", "design.toml", "--to", "json"]);
        assert_eq!(sent.status, 0, "{}", sent.err);
        // A ratio beyond the family, and a gear of another.
        for (other, told) in [
            ("ratio = 17", "a ratio of 17 is outside the requirement's range"),
            ("gear = \"compact-u8-sspg-7\"", "the requirement does not allow the gear `compact-u8-sspg-7`"),
            ("gear = \"compact-u8-cpg-17\"", "there is no gear `compact-u8-cpg-17`"),
        ] {
            fs::write(folder.path().join("design.toml"), replaced(&text, line, other)).unwrap();
            let checked = run(&folder, &["check", "design.toml"]);
            assert!(checked.status == 2 && checked.err.contains(told), "{other}: {}{}", checked.out, checked.err);
        }
    }
}

#[test]
fn the_catalogue_shows_families() {
    let folder = folder();
    let list = collapsed(&run(&folder, &["catalog", "list", "families"]).out);
    assert!(list.contains("compact-u8-cpg") && list.contains("3 gear families."), "{list}");
    let all = collapsed(&run(&folder, &["catalog", "list"]).out);
    assert!(all.contains("and 3 gear families."), "{all}");
    let gears = run(&folder, &["catalog", "list", "gears"]).out;
    assert!(!gears.contains("compact-u8-cpg"), "{gears}");
    let family = run(&folder, &["catalog", "show", "compact-u8-cpg"]);
    assert!(family.out.contains("compact-u8-cpg-9.171") && collapsed(&family.out).contains("70 MPa"), "{}", family.out);
    let point = run(&folder, &["catalog", "show", "compact-u8-cpg-9.171"]);
    assert!(point.out.contains("inertia: it is left out"), "{}", point.out);
    let shown: Value =
        serde_json::from_str(&run(&folder, &["catalog", "show", "compact-u8-cpg", "--json"]).out).unwrap();
    assert_eq!(shown["kind"], "gear family");
    assert_eq!(shown["family"]["points"].as_array().unwrap().len(), 13);
    assert_eq!(shown["family"]["stress_limit_pa"], 7e7);
    for (words, told) in [
        (&["catalog", "list", "families", "mass<1kg"][..], "gear families have no columns"),
        (&["catalog", "list", "families", "--csv"], "a gear family is no table"),
        (&["catalog", "show", "compact-u8-cp"], "did you mean `compact-u8-cpg`"),
    ] {
        let ran = run(&folder, words);
        assert!(ran.status == 2 && ran.err.contains(told), "{words:?}: {}{}", ran.out, ran.err);
    }
}

#[test]
fn a_family_of_ones_own_is_read_audited_and_compared() {
    let folder = folder();
    let mine = "name = \"mine\"\nkind = \"planetary\"\nstages = 1\nsource = \"me\"\nsource_kind = \"derived\"\n\
                [[point]]\nratio = 5\nefficiency = 0.9\n[[point]]\nratio = 40\nefficiency = 0.9\n";
    fs::write(folder.path().join("mine.toml"), mine).unwrap();
    fs::create_dir_all(folder.path().join("own/gear_families")).unwrap();
    fs::write(folder.path().join("own/gear_families/mine.toml"), mine).unwrap();
    for also in ["mine.toml", "own"] {
        let list = run(&folder, &["catalog", "list", "families", "--also", also]).out;
        assert!(list.contains("mine") && list.contains("4 gear families"), "{also}: {list}");
    }
    // One planetary stage of 40:1 does not add up.
    let audit = run(&folder, &["audit", "mine.toml"]);
    assert!(audit.out.contains("mine-40"), "{}{}", audit.out, audit.err);
    fs::write(folder.path().join("other.toml"), mine.replacen("0.9", "0.91", 1)).unwrap();
    let diff = run(&folder, &["catalog", "diff", "mine.toml", "other.toml"]).out;
    assert!(diff.contains("mine-5") && !diff.contains("mine-40"), "{diff}");
    fs::write(folder.path().join("mine.toml"), mine.replace("40", "7")).unwrap();
    let added = run(&folder, &["catalog", "add", "mine.toml", "--to", "gears.csv"]);
    assert!(added.status == 2 && added.err.contains("is a gear family, which is no row of a table"), "{}", added.err);
    let wrong = run(&folder, &["optimize", "mine.toml"]);
    assert!(
        wrong.status == 2 && wrong.err.contains("this is a gear family (keys `point`); a requirement is wanted"),
        "{}",
        wrong.err
    );
}

/// The rows that a ratio between points rests on are locked: both points, and what their family says of all.
#[test]
fn a_lock_holds_the_points_that_a_ratio_lies_between() {
    let folder = folder();
    let family = |efficiency: &str, stress: &str| {
        format!(
            "name = \"mine\"\nkind = \"planetary\"\nstages = 1\nstress_limit = \"{stress}\"\nmass_covers = \"gear\"\nsource = \"me\"\n\
             source_kind = \"derived\"\n[[point]]\nratio = 4\nefficiency = 0.95\nmass = \"100 g\"\n[[point]]\nratio = 9\nefficiency = {efficiency}\nmass = \"250 g\"\n"
        )
    };
    let robot =
        ROBOT.replace("compact-u8-cpg", "mine").replace("objective", "motors = [\"t-motor-u8-lee\"]\nobjective");
    let robot = robot.replace("[joint.limits]", "[joint.limits]\nactuator_mass = \"460 g\"");
    fs::write(folder.path().join("robot.toml"), robot).unwrap();
    fs::write(folder.path().join("mine.toml"), family("0.93", "70 MPa")).unwrap();
    let made = run(&folder, &["optimize", "robot.toml", "--also", "mine.toml", "--write-design", "design.toml"]);
    assert_eq!(made.status, 0, "{}{}", made.out, made.err);
    assert!(!made.err.contains("can be built"), "{}", made.err);
    let text = fs::read_to_string(folder.path().join("design.toml")).unwrap();
    assert!(text.contains("# between the points mine-4 and mine-9: nobody published this gear"), "{text}");
    assert_eq!(run(&folder, &["check", "design.toml", "--lock"]).status, 0);
    let same = collapsed(&run(&folder, &["check", "design.toml"]).out);
    assert!(same.contains("rows as locked"), "{same}");
    for (efficiency, stress, column) in
        [("0.90", "70 MPa", "mine-9 has changed: efficiency"), ("0.93", "60 MPa", "mine-9 has changed: stress_limit")]
    {
        fs::write(folder.path().join("mine.toml"), family(efficiency, stress)).unwrap();
        let changed = run(&folder, &["check", "design.toml"]);
        let out = collapsed(&changed.out);
        assert!(!out.contains("rows as locked") && out.contains(column), "{column}: {out}");
    }
}

/// A limit that differs between the points is asked of the points alone.
#[test]
fn a_length_between_points_is_not_judged_and_at_points_it_is() {
    let limit = |length: &str| ROBOT.replace("[joint.limits]", &format!("[joint.limits]\naxial_length = \"{length}\""));
    let refused = with(&limit("85 mm"), &["optimize", "robot.toml"]);
    assert!(refused.status == 2 && refused.err.contains("differ in what `axial_length` asks for"), "{}", refused.err);
    let points = |length: &str| with(&limit(length).replace("between = true\n", ""), &["optimize", "robot.toml"]);
    // The published length of the actuator with its motor: 83.34 mm at 12.12, 85.71 mm at 13.09.
    let kept = collapsed(&points("85 mm").out);
    assert!(kept.contains("with compact-u8-cpg-12.12"), "{kept}");
    assert_eq!(points("60 mm").status, 1);
}

#[test]
fn a_gear_of_another_family_is_not_allowed_wherever_it_is_named() {
    let other = collapsed(&with(ROBOT, &["explain", "t-motor-u8-lee@compact-u8-dspg-10.04", "robot.toml"]).out);
    assert!(other.contains("a gear that the requirement does not allow"), "{other}");
    let own = collapsed(&with(ROBOT, &["explain", "t-motor-u8-lee@compact-u8-cpg-9.171", "robot.toml"]).out);
    assert!(!own.contains("does not allow"), "{own}");
    let binds = collapsed(&with(ROBOT, &["explain", "t-motor-u8-lee", "robot.toml", "--set", LIGHT]).out);
    assert!(binds.contains("actuator_mass binds at N*; it has no shadow price here"), "{binds}");
    assert!(!binds.contains("no limit binds"), "{binds}");
}

#[test]
fn a_front_of_a_family_has_its_points_and_does_not_claim_what_lies_between() {
    let front = collapsed(&with(ROBOT, &["optimize", "robot.toml", "--pareto", "loss,mass"]).out);
    assert!(
        front.contains("what lies between points is not known") && !front.contains("every ratio between"),
        "{front}"
    );
    let csv = with(ROBOT, &["optimize", "robot.toml", "--pareto", "loss,mass", "--csv"]).out;
    for ratio in ["9.17083333", "13.0909090", "15.5892857"] {
        assert!(csv.contains(ratio), "{ratio}: {csv}");
    }
    // Ratios that the point at 9.171 betters in both are not on it.
    let ratios: Vec<f64> = csv.lines().filter_map(|line| line.split(',').nth(6)?.parse().ok()).collect();
    assert!(ratios.len() > 20 && !ratios.iter().any(|n| (8.0..9.17).contains(n)), "{ratios:?}");
}

#[test]
fn inertia_that_nobody_knows_is_no_objective() {
    let inertia = ROBOT.replace("objective = \"loss\"", "objective = \"reflected_inertia\"");
    let none = collapsed(&with(&inertia, &["optimize", "robot.toml"]).out);
    assert!(none.contains("NO motor that can be judged can do"), "{none}");
    let front = collapsed(&with(ROBOT, &["optimize", "robot.toml", "--pareto", "loss,reflected_inertia"]).out);
    assert!(front.contains("cannot be judged") || front.contains("no motor"), "{front}");
}
