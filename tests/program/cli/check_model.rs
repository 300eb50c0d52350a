//! Robot models against hardware: cases that were reported in public, written anew; a consistent model and its mutations;
//! what is not known; wrong input.

use std::collections::BTreeSet;
use std::fs;
use std::sync::LazyLock;

use serde_json::Value;
use tempfile::TempDir;

use super::folder::Ran;
use super::json::published;
use crate::common::repository;

/// Modules of the tests. `dog` has what the actuator of a quadruped of 15 kg is said to have.
const MODULES: &str = "id,kind,ratio,drive,peak_torque [N*m],rated_torque [N*m],stall_torque [N*m],no_load_speed [rad/s],voltage [V],driving_curve [rad/s : N*m],armature [kg*m^2],armature_side,dynamic_friction [N*m],viscous_friction [N*m*s/rad],friction_side,mass [kg],source,source_kind
dog,planetary,6.33,built_in,23.7,8,,30.1,28,0:23.7 20:23.7 30.1:0,0.0003,motor,0.2,0.01,output,0.6,a sheet of a dog,secondary
servo,spur,353.5,built_in,,,4.1,4.82,12,,,,,,,0.082,a manual of a servo,datasheet
arm,planetary,9,built_in,40,20,,17,24,,0.000195,motor,,,,0.92,a wiki,secondary
ankle,planetary,14,built_in,50,,,37,48,,,,,,,,a table,secondary
humanoid,strain_wave,50,built_in,180,60,,8,48,,,,,,,,a brochure,datasheet
bare,planetary,6.22,built_in,,,,,,,,,,,,,a teardown,secondary
";

const DOG: &str = r#"[[joint]]
names = ["*_hip_joint"]
module = "dog"

[[joint]]
names = ["*_calf_joint"]
module = "dog"
transmission = { ratio = 1.917 }
"#;

/// A folder with the modules, a file of hardware, and models.
fn folder(hardware: &str, models: &[(&str, &str)]) -> TempDir {
    let folder = TempDir::new().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("modules.csv", MODULES);
    write("hardware.toml", hardware);
    models.iter().for_each(|(name, text)| write(name, text));
    folder
}

/// Runs the check of these models.
fn run(folder: &TempDir, arguments: &[&str]) -> Ran {
    let mut all = vec!["check-model"];
    all.extend(arguments);
    all.extend(["--against", "hardware.toml", "--catalog", "builtin", "modules.csv"]);
    super::folder::run(folder, &all)
}

/// What `--json` says of one model.
fn json(hardware: &str, models: &[(&str, &str)]) -> (i32, Value) {
    let folder = folder(hardware, models);
    let mut arguments: Vec<&str> = models.iter().map(|(name, _)| *name).collect();
    arguments.push("--json");
    let ran = run(&folder, &arguments);
    assert_eq!(ran.err, "");
    let value: Value = serde_json::from_str(&ran.out).unwrap();
    assert_schema(&value);
    (ran.status, value)
}

/// That an answer has the published form.
fn assert_schema(value: &Value) {
    static SCHEMA: LazyLock<jsonschema::Validator> = LazyLock::new(published);
    let wrong: Vec<String> = SCHEMA.iter_errors(value).map(|e| format!("{}: {e}", e.instance_path())).collect();
    assert!(wrong.is_empty(), "{wrong:?}");
}

/// Codes of the findings.
fn codes(value: &Value) -> Vec<&str> {
    value["findings"].as_array().unwrap().iter().map(|f| f["code"].as_str().unwrap()).collect()
}

fn finding<'v>(value: &'v Value, code: &str) -> &'v Value {
    let all = value["findings"].as_array().unwrap();
    all.iter().find(|f| f["code"] == code).unwrap_or_else(|| panic!("{code} is not among {:?}", codes(value)))
}

fn holds(text: &Value, part: &str) {
    assert!(text.as_str().unwrap().contains(part), "{part} is not in {text}");
}

/// A URDF of these joints: name and attributes of the limit.
fn urdf(joints: &[(&str, &str)]) -> String {
    let one = |(name, limit): &(&str, &str)| {
        format!(
            "  <joint name=\"{name}\" type=\"revolute\">\n    <parent link=\"base\"/><child link=\"{name}_link\"/>\n    <limit {limit}/>\n  </joint>\n  <link name=\"{name}_link\"/>\n"
        )
    };
    format!("<robot name=\"r\">\n  <link name=\"base\"/>\n{}</robot>\n", joints.iter().map(one).collect::<String>())
}

fn of_all(module: &str) -> String {
    format!("[[joint]]\nnames = [\"*\"]\nmodule = \"{module}\"\n")
}

/// Interbotix #253: 20 N·m at a servo with a stall torque of 4.1 N·m.
#[test]
fn an_effort_of_five_times_the_servo() {
    let model = urdf(&[("waist", "effort=\"20\" velocity=\"4.8\"")]);
    let (status, value) = json(&of_all("servo"), &[("arm.urdf", &model)]);
    assert_eq!((status, codes(&value)), (1, vec!["GW401"]));
    let found = finding(&value, "GW401");
    assert_eq!((found["value"].as_f64(), found["bound"].as_f64()), (Some(20.0), Some(4.1)));
    assert_eq!(found["hardware"]["source"], "a manual of a servo");
    assert_eq!(found["hardware"]["conversion"], "stall_torque 4.1 N*m");
    assert_eq!((found["at"]["line"].as_u64(), found["at"]["column"].as_u64()), (Some(5), Some(20)));
    assert_eq!(found["help"], "write 4.1 N*m");
    // The shipped row of the servo says the same.
    let (_, value) = json(&of_all("robotis-xm430-w350"), &[("arm.urdf", &model)]);
    assert_eq!(finding(&value, "GW401")["bound"].as_f64(), Some(4.1));
}

/// IsaacLab #7479: 23.7 N·m and 30.1 rad/s at every joint, the calf behind r = 1.917.
#[test]
fn a_calf_with_the_limits_of_the_hip() {
    let limit = "effort=\"23.7\" velocity=\"20\"";
    let both = "effort=\"23.7\" velocity=\"30.1\"";
    let model = urdf(&[("FL_hip_joint", both), ("FL_calf_joint", both)]);
    let (status, value) = json(DOG, &[("dog.urdf", &model)]);
    assert_eq!(status, 1);
    let found = finding(&value, "GW409");
    assert_eq!(found["joint"], "FL_calf_joint");
    // 713.37 W at both: 45.43 N·m × 15.70 rad/s.
    holds(&found["message"], "713.4 W");
    assert_eq!(found["help"], "write velocity 15.7 rad/s; the effort may be 45.43 N*m");
    assert!(!codes(&value).contains(&"GW403"), "one cause is found once: {:?}", codes(&value));
    // Limits that both hardware keeps may be meant: no error, and nothing to raise.
    let low = "effort=\"20\" velocity=\"12\"";
    let derated = urdf(&[("FL_hip_joint", low), ("FL_calf_joint", low)]);
    let (_, value) = json(DOG, &[("dog.urdf", &derated)]);
    assert_eq!(finding(&value, "GW409")["severity"], "warning", "{value}");
    assert_eq!(finding(&value, "GW409")["instead"].as_array().map_or(0, Vec::len), 0, "{value}");
    // Written right there is none.
    let right = urdf(&[("FL_hip_joint", limit), ("FL_calf_joint", "effort=\"45.43\" velocity=\"10.4\"")]);
    let (status, value) = json(DOG, &[("dog.urdf", &right)]);
    assert_eq!((status, value["errors"].as_u64()), (0, Some(0)), "{value}");
}

/// IsaacLab #2103: an effort above the saturation, and a line that ends early.
#[test]
fn a_saturation_below_the_effort() {
    let above = r#"{"FL_hip_joint": {"effort": 33.5, "saturation": 23.7, "velocity": 30.1}}"#;
    let (status, value) = json("[[joint]]\nnames = [\"*\"]\nmodule = \"bare\"\n", &[("limits.json", above)]);
    assert_eq!((status, codes(&value)), (1, vec!["GW415"]));
    let early = r#"{"FL_hip_joint": {"effort": 23.7, "saturation": 70.7, "velocity": 20}}"#;
    let (status, value) = json("[[joint]]\nnames = [\"*\"]\nmodule = \"dog\"\n", &[("limits.json", early)]);
    assert_eq!((status, finding(&value, "GW415")["bound"].as_f64()), (1, Some(30.1)));
}

/// A line may end at the largest speed that the gear allows: the same velocity keeps GW403 and GW415.
#[test]
fn a_line_ends_at_the_largest_speed_of_the_gear() {
    let catalog = gearwise::catalog::Catalog::builtin().unwrap();
    let gear = catalog.gears.iter().find(|gear| gear.max_input_speed.is_some()).unwrap();
    let hardware = format!(
        "[[joint]]\nnames = [\"*\"]\nmotor = \"t-motor-u8-lee\"\ngear = \"{}\"\nvoltage = \"1000 V\"\n",
        gear.id
    );
    let largest = gear.max_input_speed.unwrap() / gear.ratio;
    let at = |velocity: f64| {
        let limits = format!(r#"{{"knee": {{"effort": 1e-3, "saturation": 2e-3, "velocity": {velocity}}}}}"#);
        json(&hardware, &[("limits.json", &limits)]).1
    };
    let of_speed = |value: &Value| codes(value).into_iter().filter(|code| ["GW403", "GW415"].contains(code)).count();
    assert_eq!(of_speed(&at(largest)), 0);
    assert_eq!(codes(&at(1.2 * largest)).iter().filter(|code| **code == "GW403").count(), 1);
    let early = at(0.8 * largest);
    let joint = &early["models"][0]["joints"][0];
    assert!((joint["largest_speed_rad_per_s"]["value"].as_f64().unwrap() / largest - 1.0).abs() < 1e-12);
    assert!(joint["no_load_speed_rad_per_s"]["value"].as_f64().unwrap() > largest);
    let found = finding(&early, "GW415");
    assert!((found["bound"].as_f64().unwrap() / largest - 1.0).abs() < 1e-12);
    holds(&found["message"], "below the largest speed");
}

/// IsaacLab #2478: the effort is the rated torque.
#[test]
fn an_effort_that_is_the_rated_torque() {
    let model = urdf(&[("knee", "effort=\"60\" velocity=\"8\"")]);
    let (status, value) = json(&of_all("humanoid"), &[("humanoid.urdf", &model)]);
    assert_eq!((status, codes(&value)), (0, vec!["GW402"]));
    assert_eq!(finding(&value, "GW402")["severity"], "note");
    holds(&finding(&value, "GW402")["message"], "rated torque");
    let model = urdf(&[("knee", "effort=\"100\" velocity=\"8\"")]);
    let (_, value) = json(&of_all("humanoid"), &[("humanoid.urdf", &model)]);
    assert_eq!(finding(&value, "GW402")["severity"], "warning");
}

/// openarm #336: an armature of another side, or of another actuator.
#[test]
fn an_armature_of_another_side() {
    let model = |armature: &str| {
        format!(
            "<mujoco><default><default class=\"m\"><joint armature=\"{armature}\"/></default></default><worldbody><body name=\"a\" childclass=\"m\">\n<joint name=\"j\"/></body></worldbody><actuator><motor joint=\"j\" forcerange=\"-40 40\"/></actuator></mujoco>"
        )
    };
    // 81 × 1.95e-4 kg·m² at the joint.
    for (armature, said) in [
        ("0.000195", "1/N² (N = 9)"),
        ("0.001755", "1/N (N = 9)"),
        ("0.15795", "a factor of 10"),
        ("0.0316", "a factor of 2"),
        ("1.2794", "N² (N = 9)"),
    ] {
        let (status, value) = json(&of_all("arm"), &[("arm.xml", &model(armature))]);
        assert_eq!((status, codes(&value)), (0, vec!["GW406"]), "{armature}");
        holds(&finding(&value, "GW406")["message"], said);
        holds(&finding(&value, "GW406")["hardware"]["conversion"], "N² × armature 0.000195");
    }
    let two = format!("{}[[joint]]\nnames = [\"k\"]\nmodule = \"dog\"\n", of_all("arm").replace('*', "j"));
    let (_, value) = json(&two, &[("arm.xml", &model("0.01202"))]);
    holds(&finding(&value, "GW406")["message"], "it is that of dog");
}

/// GR00T #259: every effort is 3.00 times that of the other file.
#[test]
fn a_copy_that_was_scaled() {
    let joints = |factor: f64| {
        let joint = |(name, effort): (&str, f64)| format!("\"{name}\": {{\"effort\": {}}}", effort * factor);
        let all = [("hip", 88.0), ("knee", 139.0), ("ankle", 50.0), ("elbow", 25.0)].map(joint);
        format!("{{{}}}", all.join(",\n"))
    };
    let (_, value) = json(&of_all("bare"), &[("maker.json", &joints(1.0)), ("training.json", &joints(3.0))]);
    assert_eq!(codes(&value), ["GW411"]);
    holds(&finding(&value, "GW411")["message"], "all 4 joints are 3 times those of maker.json");
    assert_eq!(finding(&value, "GW411")["at"]["file"], "training.json");
}

/// holosoma #47: 35 N·m and 30 rad/s in one file, 50 and 37 in the other.
#[test]
fn two_files_that_disagree() {
    let first = urdf(&[("left_ankle", "effort=\"35\" velocity=\"30\""), ("waist", "effort=\"50\" velocity=\"37\"")]);
    let second = urdf(&[("left_ankle", "effort=\"50\" velocity=\"37\""), ("waist", "effort=\"50\" velocity=\"37\"")]);
    let (_, value) = json(&of_all("ankle"), &[("a.urdf", &first), ("b.urdf", &second)]);
    let found = finding(&value, "GW412");
    assert_eq!(found["joint"], "left_ankle");
    assert_eq!(found["message"], "effort 50 against 35 N*m, velocity 37 against 30 rad/s in a.urdf");
    assert_eq!(
        (found["at"]["file"].as_str(), found["compared_with_at"]["file"].as_str()),
        (Some("b.urdf"), Some("a.urdf"))
    );
}

/// mini-cheetah-pybullet #2: a gear that is not the hardware's.
#[test]
fn a_gear_of_another_motor() {
    let model = |gear: &str| {
        format!(
            "<mujoco><worldbody><body name=\"a\"><joint name=\"knee\"/></body></worldbody>\n<actuator><motor joint=\"knee\" gear=\"{gear}\" ctrlrange=\"-3 3\"/></actuator></mujoco>"
        )
    };
    let hardware =
        "[[joint]]\nnames = [\"knee\"]\nmotor = \"t-motor-u8-lee\"\nratio = 6\ntransmission = { ratio = 1.55 }\n";
    let code = |gear: &str| {
        let (_, value) = json(hardware, &[("leg.xml", &model(gear))]);
        codes(&value).contains(&"GW408")
    };
    // The knee has a belt: 6 alone is not its ratio.
    assert!(code("36") && code("55.8") && code("2") && code("6"));
    assert!(!code("9.3") && !code("1") && !code("1.55"));
    let (status, value) = json(hardware, &[("leg.xml", &model("36"))]);
    assert_eq!(status, 1);
    holds(&finding(&value, "GW408")["message"], "1, r = 1.55 or N r = 9.3");
}

/// Two joints that two actuators drive together: both efforts at once ask for twice an actuator.
#[test]
fn ankles_that_are_coupled() {
    let hardware = of_all("ankle") + "[[coupling]]\njoints = [\"pitch\", \"roll\"]\nmatrix = [[1, 1], [1, -1]]\n";
    let model = |effort: &str| urdf(&[("pitch", effort), ("roll", effort)]);
    let (_, value) = json(&hardware, &[("a.urdf", &model("effort=\"80\" velocity=\"37\""))]);
    let found = finding(&value, "GW413");
    // J⁻ᵀ = [[½, ½], [½, −½]]: (80 + 80)/2.
    assert_eq!((found["value"].as_f64(), found["bound"].as_f64()), (Some(80.0), Some(50.0)));
    let (_, value) = json(&hardware, &[("a.urdf", &model("effort=\"50\" velocity=\"37\""))]);
    assert!(codes(&value).is_empty(), "{value}");
    assert!(value["not_judged"].as_array().unwrap().iter().any(|n| n["code"] == "GW401"));
}

/// Legs of a quadruped, each with a hip and a calf behind a belt: every number is that of its hardware, and every box lies
/// under its curve.
const LEGS: [&str; 4] = ["FL", "FR", "RL", "RR"];

fn consistent_mjcf() -> String {
    let leg = |leg: &&str| {
        format!(
            "    <body name=\"{leg}_hip\">\n      <inertial pos=\"0 0 0\" mass=\"0.7\" diaginertia=\"1 1 1\"/>\n      <joint name=\"{leg}_hip_joint\" class=\"hip\"/>\n      <body name=\"{leg}_calf\">\n        <inertial pos=\"0 0 0\" mass=\"0.2\" diaginertia=\"1 1 1\"/>\n        <joint name=\"{leg}_calf_joint\" class=\"calf\"/>\n      </body>\n    </body>\n"
        )
    };
    let motor = |leg: &&str| {
        format!(
            "    <motor name=\"{leg}_hip\" joint=\"{leg}_hip_joint\" class=\"hip\"/>\n    <motor name=\"{leg}_calf\" joint=\"{leg}_calf_joint\" class=\"calf\"/>\n"
        )
    };
    format!(
        "<mujoco model=\"dog\">\n  <default>\n    <default class=\"hip\">\n      <joint armature=\"0.01202\" frictionloss=\"0.2\" damping=\"0.01\"/>\n      <motor gear=\"1\" forcerange=\"-23.7 23.7\"/>\n    </default>\n    <default class=\"calf\">\n      <joint armature=\"0.04418\" frictionloss=\"0.383\" damping=\"0.0367\"/>\n      <motor gear=\"1.917\" forcerange=\"-23.7 23.7\"/>\n    </default>\n  </default>\n  <worldbody>\n    <body name=\"base\">\n      <freejoint/>\n      <inertial pos=\"0 0 0\" mass=\"6\" diaginertia=\"1 1 1\"/>\n    </body>\n{}  </worldbody>\n  <actuator>\n{}  </actuator>\n  <equality><connect body1=\"base\" anchor=\"0 0 0\"/></equality>\n  <tendon><fixed name=\"t\"><joint joint=\"FL_hip_joint\" coef=\"1\"/></fixed></tendon>\n</mujoco>\n",
        LEGS.iter().map(leg).collect::<String>(),
        LEGS.iter().map(motor).collect::<String>()
    )
}

fn consistent_urdf() -> String {
    let leg = |leg: &&str| {
        format!(
            "  <link name=\"{leg}_hip\"><inertial><mass value=\"0.7\"/></inertial></link>\n  <link name=\"{leg}_calf\"><inertial><mass value=\"0.2\"/></inertial></link>\n  <joint name=\"{leg}_hip_joint\" type=\"revolute\"><parent link=\"base\"/><child link=\"{leg}_hip\"/>\n    <limit effort=\"23.7\" velocity=\"20\" lower=\"-1\" upper=\"1\"/><dynamics friction=\"0.2\" damping=\"0.01\"/></joint>\n  <joint name=\"{leg}_calf_joint\" type=\"revolute\"><parent link=\"{leg}_hip\"/><child link=\"{leg}_calf\"/>\n    <limit effort=\"45.43\" velocity=\"10.43\" lower=\"-1\" upper=\"1\"/><dynamics friction=\"0.383\" damping=\"0.0367\"/></joint>\n"
        )
    };
    format!(
        "<robot name=\"dog\">\n  <link name=\"base\"><inertial><mass value=\"6\"/></inertial></link>\n{}  <joint name=\"foot\" type=\"revolute\"><mimic joint=\"FL_calf_joint\"/><parent link=\"FL_calf\"/><child link=\"f\"/></joint>\n  <link name=\"f\"/>\n</robot>\n",
        LEGS.iter().map(leg).collect::<String>()
    )
}

fn consistent_limits() -> String {
    let joint = |name: String, numbers: &str| format!("  \"{name}\": {{{numbers}}}");
    let legs = LEGS.iter().flat_map(|leg| {
        [
            joint(format!("{leg}_hip_joint"), "\"effort\": 23.7, \"velocity\": 30.1, \"saturation\": 70.7, \"armature\": 0.01202, \"friction\": 0.2, \"damping\": 0.01"),
            joint(format!("{leg}_calf_joint"), "\"effort\": 45.43, \"velocity\": 15.7, \"saturation\": 135, \"armature\": 0.04418, \"friction\": 0.383, \"damping\": 0.0367, \"gear\": 12.13"),
        ]
    });
    format!("{{\n{}\n}}\n", legs.collect::<Vec<_>>().join(",\n"))
}

#[test]
fn a_consistent_model_has_no_finding() {
    for (name, model) in
        [("dog.xml", consistent_mjcf()), ("dog.urdf", consistent_urdf()), ("dog.json", consistent_limits())]
    {
        let (status, value) = json(DOG, &[(name, &model)]);
        assert_eq!((status, codes(&value)), (0, vec![]), "{name}: {value}");
    }
    // Even together.
    let (_, value) = json(DOG, &[("dog.xml", &consistent_mjcf()), ("dog.urdf", &consistent_urdf())]);
    assert_eq!(codes(&value), Vec::<&str>::new());
}

/// The `k`-th place of a text in another's.
fn replaced(text: &str, old: &str, new: &str, k: usize) -> String {
    let (at, _) = text.match_indices(old).nth(k).unwrap_or_else(|| panic!("{old}"));
    format!("{}{new}{}", &text[..at], &text[at + old.len()..])
}

/// One attribute of a consistent model is changed: exactly the rule that is about it finds it.
#[test]
fn every_mutation_is_found_by_its_rule_alone() {
    type Mutation = (&'static str, &'static str, &'static str);
    let mjcf: &[Mutation] = &[
        ("class=\"hip\"/>\n      <body", "class=\"hip\" armature=\"0.0003\"/>\n      <body", "GW406"),
        ("class=\"hip\"/>\n      <body", "class=\"hip\" armature=\"0\"/>\n      <body", "GW405"),
        ("class=\"hip\"/>\n      <body", "class=\"hip\" frictionloss=\"0.01\"/>\n      <body", "GW407"),
        ("class=\"calf\"/>\n      </body", "class=\"calf\" damping=\"2\"/>\n      </body", "GW407"),
        ("_hip_joint\" class=\"hip\"/>\n    <motor", "_hip_joint\" class=\"hip\" gear=\"40\"/>\n    <motor", "GW408"),
        (
            "_hip_joint\" class=\"hip\"/>\n    <motor",
            "_hip_joint\" class=\"hip\" forcerange=\"-50 50\"/>\n    <motor",
            "GW401",
        ),
        (
            "_hip_joint\" class=\"hip\"/>\n    <motor",
            "_hip_joint\" class=\"hip\" forcerange=\"-15 15\"/>\n    <motor",
            "GW402",
        ),
        (
            "_hip_joint\" class=\"hip\"/>\n    <motor",
            "_hip_joint\" class=\"hip\" forcerange=\"-23 23\"/>\n    <motor",
            "GW410",
        ),
        ("mass=\"0.7\"", "mass=\"0.5\"", "GW414"),
    ];
    let urdf: &[Mutation] = &[
        ("effort=\"23.7\"", "effort=\"47.4\"", "GW401"),
        ("effort=\"45.43\"", "effort=\"15.336\"", "GW402"),
        ("effort=\"45.43\"", "effort=\"30\"", "GW402"),
        ("velocity=\"20\"", "velocity=\"1150\"", "GW403"),
        ("velocity=\"10.43\"", "velocity=\"10.4\"", "GW410"),
        ("velocity=\"20\"", "velocity=\"30\"", "GW404"),
        ("friction=\"0.2\"", "friction=\"0\"", "GW407"),
        ("value=\"0.7\"", "value=\"0.07\"", "GW414"),
        ("name=\"FL_calf_joint\"", "name=\"FL_claf_joint\"", "GW416"),
    ];
    let limits: &[Mutation] = &[
        ("\"saturation\": 70.7", "\"saturation\": 20", "GW415"),
        ("\"velocity\": 30.1", "\"velocity\": 25", "GW415"),
        ("\"velocity\": 30.1", "\"velocity\": 287.4", "GW403"),
        ("\"armature\": 0.01202", "\"armature\": 0", "GW405"),
        ("\"gear\": 12.13", "\"gear\": 40.07", "GW408"),
    ];
    let mut found: BTreeSet<&str> = BTreeSet::new();
    for (name, model, mutations) in [
        ("dog.xml", consistent_mjcf(), mjcf),
        ("dog.urdf", consistent_urdf(), urdf),
        ("dog.json", consistent_limits(), limits),
    ] {
        for (old, new, code) in mutations {
            // A velocity that leaves the curve is changed at all joints, or the sides would differ as well.
            let all = *code == "GW404";
            let mutated = if all { model.replace(old, new) } else { replaced(&model, old, new, 0) };
            let (_, value) = json(DOG, &[(name, &mutated)]);
            let distinct: BTreeSet<&str> = codes(&value).into_iter().collect();
            assert_eq!(distinct, BTreeSet::from([*code]), "{name}: {new}: {value}");
            found.insert(code);
        }
    }
    assert_eq!(found.len(), 12, "{found:?}");
}

#[test]
fn what_no_row_says_is_not_judged_and_no_pass() {
    let model = urdf(&[("a", "effort=\"1000\" velocity=\"1000\"")]);
    let (status, value) = json(&of_all("bare"), &[("m.urdf", &model)]);
    assert_eq!((status, codes(&value), value["judged"].as_bool()), (1, vec![], Some(false)));
    let rules: Vec<&str> =
        value["not_judged"].as_array().unwrap().iter().map(|n| n["code"].as_str().unwrap()).collect();
    assert_eq!(rules, ["GW401", "GW402", "GW403", "GW404", "GW405", "GW407"]);
    let at = folder(&of_all("bare"), &[("m.urdf", &model)]);
    let text = run(&at, &["m.urdf"]).out;
    assert!(text.contains("nothing could be judged") && text.contains("not judged: GW401"), "{text}");

    // Where something can be judged it passes, but not strictly while a limit is unknown.
    let hardware = "[[joint]]\nnames = [\"a\"]\nmodule = \"bare\"\n[[joint]]\nnames = [\"b\"]\nmodule = \"ankle\"\n";
    let model = urdf(&[("a", "effort=\"1000\" velocity=\"1000\""), ("b", "effort=\"50\" velocity=\"37\"")]);
    let at = folder(hardware, &[("m.urdf", &model)]);
    assert_eq!((run(&at, &["m.urdf"]).status, run(&at, &["m.urdf", "--strict"]).status), (0, 1));
}

/// A gear whose input speed or peak torque nobody prints leaves the question open; above what the motor does it is an error.
#[test]
fn what_a_gear_allows_is_not_taken_for_granted() {
    let hardware = "[[joint]]\nnames = [\"a\"]\nmotor = \"maxon-ec-4pole-22-323217\"\ngear = \"planetary-maxon-gp22hp-14-370687\"\nvoltage = \"48 V\"\n";
    let of = |velocity: &str| {
        let (_, value) =
            json(hardware, &[("m.urdf", &urdf(&[("a", &format!("effort=\"1\" velocity=\"{velocity}\""))]))]);
        let open = value["not_judged"].as_array().unwrap().iter().any(|n| n["code"] == "GW403");
        (open, codes(&value).contains(&"GW403"))
    };
    assert_eq!((of("180"), of("300")), ((true, false), (false, true)));

    // A momentary peak is more than the repeated one, which is not known.
    let motors = "id,terminals,current,resistance [ohm],torque_constant [N*m/A],rotor_inertia [kg*m^2],peak_current [A],source,source_kind\nweak,q_axis,q_axis,1,0.1,1e-5,10,s,derived\nstrong,q_axis,q_axis,1,0.1,1e-5,90,s,derived\n";
    let gears = "id,kind,ratio,efficiency,momentary_peak_torque [N*m],max_input_speed [rad/s],source,source_kind\ng,strain_wave,50,0.8,100,500,s,derived\n";
    let at = |motor: &str, effort: &str| {
        let hardware = format!("[[joint]]\nnames = [\"a\"]\nmotor = \"{motor}\"\ngear = \"g\"\n");
        let model = urdf(&[("a", &format!("effort=\"{effort}\" velocity=\"1\""))]);
        let folder = folder(&hardware, &[("m.urdf", &model), ("motors.csv", motors), ("gears.csv", gears)]);
        let files =
            ["check-model", "m.urdf", "--json", "--against", "hardware.toml", "--catalog", "motors.csv", "gears.csv"];
        let value: Value = serde_json::from_str(&super::folder::run(&folder, &files).out).unwrap();
        let open = value["not_judged"].as_array().unwrap().iter().any(|n| n["code"] == "GW401");
        (open, codes(&value).into_iter().filter(|code| *code == "GW401" || *code == "GW402").count())
    };
    assert_eq!((at("weak", "40"), at("weak", "45")), ((true, 0), (false, 1)));
    assert_eq!((at("strong", "80"), at("strong", "120")), ((false, 0), (false, 1)));
}

#[test]
fn voltage_takes_from_the_speed_and_never_adds() {
    let free = |hardware: &str| {
        let (_, value) = json(hardware, &[("m.urdf", &urdf(&[("a", "effort=\"50\" velocity=\"1\"")]))]);
        value["models"][0]["joints"][0]["no_load_speed_rad_per_s"]["value"].as_f64().unwrap()
    };
    let at = |voltage: &str| free(&format!("{}voltage = \"{voltage}\"\n", of_all("ankle")));
    assert!((free(&of_all("ankle")) - 37.0).abs() < 1e-12);
    assert!((at("24 V") - 18.5).abs() < 1e-12 && (at("60 V") - 37.0).abs() < 1e-12);
}

/// A motor and a gear of the catalogue: torque × N η r, inertia × (N r)².
#[test]
fn a_motor_with_a_ratio() {
    let hardware = "[[joint]]\nnames = [\"a\"]\nmotor = \"t-motor-u8-lee\"\nratio = 6\nvoltage = \"24 V\"\ntransmission = { ratio = 1.5 }\n";
    let (_, value) = json(hardware, &[("m.urdf", &urdf(&[("a", "effort=\"1\" velocity=\"1\"")]))]);
    let joint = &value["models"][0]["joints"][0];
    let catalog = gearwise::catalog::Catalog::builtin().unwrap();
    let motor = catalog.motor("t-motor-u8-lee").unwrap();
    let same = |key: &str, expected: f64| {
        let value = joint[key]["value"].as_f64().unwrap();
        assert!((value / expected - 1.0).abs() < 1e-12, "{key}: {value} {expected}");
    };
    same("inertia_kgm2", 81.0 * motor.rotor_inertia.unwrap());
    assert_eq!(joint["inertia_kgm2"]["at_least"], true);
    let free = 24.0 / (2f64.sqrt() * motor.emf_constant());
    same("no_load_speed_rad_per_s", free / 9.0);
    same("largest_speed_rad_per_s", motor.max_speed.map_or(free, |most| most.min(free)) / 9.0);
    let peak = motor.peak_torque.or(motor.peak_current.map(|i| motor.torque_constant * i)).unwrap();
    same("peak_torque_nm", 9.0 * peak);
}

/// A design that was written into a model with `export` has no error there, and its effort is the peak torque.
#[test]
fn an_exported_model_agrees() {
    let at = TempDir::new().unwrap();
    let design = repository("requirements/designs/quadruped_mini_cheetah/design.toml");
    let model = urdf(&[("hip_abad", "effort=\"0\""), ("hip", "effort=\"0\""), ("knee", "effort=\"0\"")]);
    fs::write(at.path().join("leg.urdf"), model).unwrap();
    fs::write(
        at.path().join("hardware.toml"),
        "[[joint]]\nnames = [\"hip*\"]\nmotor = \"t-motor-u8-lee\"\nratio = 6\nvoltage = \"24 V\"\n".to_string()
            + "drive_current = \"40 A\"\n\n[[joint]]\nnames = [\"knee\"]\nmotor = \"t-motor-u8-lee\"\nratio = 6\nvoltage = \"24 V\"\n\
               drive_current = \"40 A\"\ntransmission = { ratio = 1.555 }\n",
    )
    .unwrap();
    let exported =
        super::folder::run(&at, &["export", design.to_str().unwrap(), "--into", "leg.urdf", "--out", "out.urdf"]);
    assert_eq!(exported.status, 0, "{}", exported.err);
    let ran = super::folder::run(&at, &["check-model", "out.urdf", "--against", "hardware.toml", "--json"]);
    let value: Value = serde_json::from_str(&ran.out).unwrap();
    assert_eq!((ran.status, codes(&value)), (0, vec![]), "{value}");
}

#[test]
fn a_fix_writes_what_the_findings_say_and_nothing_else() {
    for (name, model, old, new) in [
        ("dog.urdf", consistent_urdf(), "effort=\"23.7\"", "effort=\"47.4\""),
        ("dog.json", consistent_limits(), "\"armature\": 0.01202, ", ""),
        ("dog.xml", consistent_mjcf(), "class=\"hip\"/>\n      <body", "class=\"hip\" armature=\"0\"/>\n      <body"),
    ] {
        let broken = replaced(&model, old, new, 1);
        let at = folder(DOG, &[(name, &broken)]);
        let ran = run(&at, &[name, "--fix"]);
        assert!(ran.out.contains("in place of"), "{}", ran.out);
        let (stem, extension) = name.split_once('.').unwrap();
        let copy = format!("{stem}.fixed.{extension}");
        assert!(ran.out.contains(&format!("written to {copy}")), "{}", ran.out);
        assert_eq!(fs::read_to_string(at.path().join(name)).unwrap(), broken, "the model stays as it is");
        let again = run(&at, &[&copy, "--json"]);
        let value: Value = serde_json::from_str(&again.out).unwrap();
        assert_eq!(codes(&value), Vec::<&str>::new(), "{name}");
        let nothing = run(&at, &[&copy, "--fix"]).out;
        assert!(nothing.contains("nothing to fix"), "{nothing}");
    }
    // A number of a class is written at the joint: the class holds for others.
    let broken = consistent_mjcf().replace("-23.7 23.7", "-60 60");
    let at = folder(DOG, &[("dog.xml", &broken)]);
    run(&at, &["dog.xml", "--fix", "--out", "right.xml"]);
    let text = fs::read_to_string(at.path().join("right.xml")).unwrap();
    assert!(
        text.contains("<motor forcerange=\"-23.7 23.7\" name=\"FL_calf\"") && text.contains("\"-60 60\""),
        "{text}"
    );
    assert_eq!(run(&at, &["right.xml"]).status, 0);
}

#[test]
fn machines_get_places_and_rows() {
    let model = urdf(&[("waist", "effort=\"20\" velocity=\"4.8\"")]);
    let at = folder(&of_all("servo"), &[("arm.urdf", &model)]);
    let ran = run(&at, &["arm.urdf", "--sarif", "c.sarif", "--junit", "c.xml", "--github"]);
    assert_eq!(ran.status, 1);
    assert!(ran.out.starts_with("::error file=arm.urdf,line=5,col=20,"), "{}", ran.out);
    assert!(ran.out.contains("a manual of a servo"));
    let sarif: Value = serde_json::from_str(&fs::read_to_string(at.path().join("c.sarif")).unwrap()).unwrap();
    let result = &sarif["runs"][0]["results"][0];
    assert_eq!(result["ruleId"], "GW401");
    assert_eq!(
        sarif["runs"][0]["tool"]["driver"]["rules"][result["ruleIndex"].as_u64().unwrap() as usize]["id"],
        "GW401"
    );
    assert_eq!(result["locations"][0]["physicalLocation"]["region"]["startLine"], 5);
    let junit = fs::read_to_string(at.path().join("c.xml")).unwrap();
    assert!(junit.contains("failures=\"1\"") && junit.contains("GW401 effort-above-peak"), "{junit}");
}

#[test]
fn severities_and_exceptions_of_a_rules_file() {
    let model = urdf(&[("waist", "effort=\"20\" velocity=\"4.8\""), ("elbow", "effort=\"20\" velocity=\"4.8\"")]);
    let at = folder(&of_all("servo"), &[("arm.urdf", &model)]);
    let rules = |text: &str| {
        fs::write(at.path().join("rules.toml"), text).unwrap();
        let ran = run(&at, &["arm.urdf", "--rules", "rules.toml", "--json"]);
        (ran.status, serde_json::from_str::<Value>(&ran.out).unwrap())
    };
    let (status, value) = rules("[[rule]]\nrule = \"GW401\"\nseverity = \"warning\"\nreason = \"springs help\"\n");
    assert_eq!((status, value["warnings"].as_u64()), (0, Some(2)));
    assert_eq!(value["findings"][0]["reason"], "springs help");
    let allow = |joint: &str| {
        format!("[[allow]]\nrule = \"effort-above-peak\"\njoints = [\"{joint}\"]\nreason = \"two servos\"\n")
    };
    let (status, value) = rules(&allow("waist"));
    assert_eq!((status, value["errors"].as_u64()), (1, Some(1)));
    assert_eq!(rules(&allow("*")).0, 0);
    let (_, value) = rules(&allow("wrist"));
    assert!(codes(&value).contains(&"GW301"));
}

#[test]
fn wrong_input_is_refused_with_its_place() {
    let model = urdf(&[("a", "effort=\"50\" velocity=\"37\"")]);
    let hardware = of_all("ankle");
    let refused = |hardware: &str, name: &str, model: &[u8], said: &[&str]| {
        let at = folder(hardware, &[]);
        fs::write(at.path().join(name), model).unwrap();
        let ran = run(&at, &[name]);
        assert_eq!((ran.status, ran.out.as_str()), (2, ""), "{said:?}: {}", ran.err);
        for part in said {
            assert!(ran.err.contains(part), "{part} is not in\n{}", ran.err);
        }
        assert!(ran.err.len() < 5000, "{}", ran.err.len());
    };
    let good = model.as_bytes();
    for (text, said) in [
        (hardware.replace("module", "modul"), "did you mean `module`?"),
        (hardware.replace("ankle", "ankel"), "did you mean `ankle`?"),
        (hardware.clone() + "voltage = \"48 N\"\n", "48 N"),
        (hardware.clone() + "ratio = 9\n", "a module has its gear inside"),
        (hardware.clone() + "transmission = { ratio = nan }\n", "ratio"),
        (hardware.clone() + "transmission = { ratio = 0 }\n", "0 is not a ratio"),
        (hardware.clone() + "[limits]\ntolerance = 5\n", "for 5 % write 0.05"),
        (hardware.clone() + &hardware, "named by two [[joint]]"),
        (hardware.replace("names = [\"*\"]\n", ""), "`names` of [[joint]] is missing"),
        ("[[joint]]\nnames = [\"*\"]\nmotor = \"t-motor-ri50\"\n".into(), "ratio = 9"),
        ("[[joint]]\nnames = [\"*\"]\n".into(), "`module` of [[joint]] is missing"),
        (String::new(), "`joint` is missing"),
        ("[[joint]\n".into(), "not valid TOML"),
        (hardware.clone() + "[[coupling]]\njoints = [\"a\", \"b\"]\nmatrix = [[1, 1], [1, 1]]\n", "cannot be inverted"),
    ] {
        refused(&text, "m.urdf", good, &["hardware.toml:", said]);
    }
    for (from, to, said) in [
        ("\"50\"", "\"NaN\"", "is not a number"),
        ("\"50\"", "\"-50\"", "out of range"),
        ("\"37\"", "\"inf\"", "is not a number"),
        ("\"50\"", "\"fifty\"", "is not a number"),
        ("</robot>", "", "not an XML file"),
        ("<robot", "<xacro:x/><robot", "xacro"),
        ("joint name=\"a\"", "joint name=\"\"", "name"),
    ] {
        refused(&hardware, "m.urdf", model.replace(from, to).as_bytes(), &["m.urdf", said]);
    }
    for (text, said) in [
        ("{\"a\": {\"effrot\": 1}}", "did you mean `effort`?"),
        ("{\"a\": {\"effort\": NaN}}", "no finite number"),
        ("{\"a\": {\"effort\": -1}}", "out of range"),
        ("{\"a\": {\"effort\": \"1 N*m\"}}", "`effort` is a text"),
        ("{\"a\": {\"effort\": 1, \"effort\": 2}}", "two times `effort`"),
        ("{\"a\": {\"effort\": 1}, \"a\": {}}", "two joints are called `a`"),
        ("{\"a\": 3}", "no table of numbers"),
        ("{}", "no joint"),
        ("{\"a\": ", "not valid JSON"),
    ] {
        refused(&hardware, "m.json", text.as_bytes(), &["m.json", said]);
    }
    refused(&hardware, "m.urdf", b"", &["m.urdf"]);
    refused(&hardware, "m.urdf", b"joint,effort\na,1\n", &["m.urdf", "wanted"]);
    let mut noise = vec![0u8; 10 << 20];
    let mut state = 1u64;
    for byte in &mut noise {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        *byte = (state >> 56) as u8;
    }
    refused(&hardware, "m.urdf", &noise, &["m.urdf"]);
    for byte in &mut noise {
        *byte = b' ' + *byte % 94;
    }
    refused(&hardware, "m.urdf", &noise, &["m.urdf"]);
    noise[0] = b'{';
    refused(&hardware, "m.json", &noise, &["m.json"]);
    noise[0] = b'<';
    refused(&hardware, "m.xml", &noise, &["m.xml"]);

    let at = folder(&hardware, &[("m.urdf", &model)]);
    let missing = run(&at, &["robot.urdf"]);
    assert!(missing.status == 2 && missing.err.contains("there is no such file"), "{}", missing.err);
    let twice = run(&at, &["m.urdf", "m.urdf", "--fix", "--out", "x"]);
    assert_eq!(twice.status, 2);
    // Pipelines get the mistakes as findings.
    fs::write(at.path().join("hardware.toml"), hardware.replace("module", "modul")).unwrap();
    let ran = run(&at, &["m.urdf", "--json"]);
    let value: Value = serde_json::from_str(&ran.out).unwrap();
    assert_schema(&value);
    assert_eq!(
        (ran.status, value["command"].as_str(), value["passes"].as_bool()),
        (2, Some("check-model"), Some(false))
    );
}

/// MuJoCo adds the forces of all actuators of a joint; one without a limit leaves none.
#[test]
fn actuators_of_one_joint_add_up() {
    let model = |actuators: &str| {
        format!(
            "<mujoco><worldbody><body><inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 1\"/><joint name=\"knee\" armature=\"0.0158\"/></body></worldbody><actuator>{actuators}</actuator></mujoco>"
        )
    };
    let forty = "<motor joint=\"knee\" forcerange=\"-40 40\"/>";
    let hardware = "[[joint]]\nnames = [\"knee\"]\nmodule = \"damiao-j8009-2ec\"\n";
    let effort = |actuators: &str| {
        let here = tempfile::TempDir::new().unwrap();
        std::fs::write(here.path().join("knee.xml"), model(actuators)).unwrap();
        std::fs::write(here.path().join("hardware.toml"), hardware).unwrap();
        let ran = super::folder::run(&here, &["check-model", "knee.xml", "--against", "hardware.toml", "--json"]);
        let value: serde_json::Value = serde_json::from_str(&ran.out).unwrap_or_else(|_| panic!("{}", ran.err));
        (ran.status, codes(&value).into_iter().map(str::to_string).collect::<Vec<_>>())
    };
    let (status, found) = effort(forty);
    assert!(status == 0 && !found.iter().any(|code| code == "GW401"), "{found:?}");
    let (status, found) = effort(&forty.repeat(2));
    assert!(status == 1 && found.iter().any(|code| code == "GW401"), "{found:?}");
    let open = format!("{forty}<position joint=\"knee\" kp=\"100\"/>");
    let (_, found) = effort(&open);
    assert!(!found.iter().any(|code| code == "GW401" || code == "GW402"), "not judged: {found:?}");
    // What limits the joint limits them all.
    let (_, found) = effort(&forty.repeat(2).replace("-40 40", "-20 20"));
    assert!(!found.iter().any(|code| code == "GW401"), "{found:?}");
}

/// At more voltage than the row's nobody says the speed; twice as much voltage is no more than twice as much of it.
#[test]
fn speeds_at_more_voltage_have_an_upper_end() {
    let row = "id,ratio,peak_torque [N*m],rated_torque [N*m],no_load_speed [rad/s],voltage [V],armature [kg*m^2],armature_side,mass [g],source,source_kind,drive\nmy,9,40,12,20,48,0.01,output,900,x,datasheet,built_in\n";
    let hardware = "[[joint]]\nnames = [\"hip\"]\nmodule = \"my\"\nvoltage = \"60 V\"\n[[joint]]\nnames = [\"knee\"]\nmodule = \"my\"\ntransmission = { ratio = 1.5 }\nvoltage = \"60 V\"\n";
    let found = |hip: f64, knee: f64| {
        let here = tempfile::TempDir::new().unwrap();
        let model = format!(
            "{{\"hip\": {{\"effort\": 40, \"velocity\": {hip}}}, \"knee\": {{\"effort\": 40, \"velocity\": {knee}}}}}"
        );
        for (name, text) in [("m.csv", row), ("hardware.toml", hardware), ("limits.json", model.as_str())] {
            std::fs::write(here.path().join(name), text).unwrap();
        }
        let arguments =
            ["check-model", "limits.json", "--against", "hardware.toml", "--catalog", "builtin", "m.csv", "--json"];
        let ran = super::folder::run(&here, &arguments);
        let value: serde_json::Value = serde_json::from_str(&ran.out).unwrap_or_else(|_| panic!("{}", ran.err));
        let errors = value["findings"].as_array().unwrap().iter().filter(|f| f["severity"] == "error");
        errors.map(|f| f["code"].as_str().unwrap().to_string()).collect::<Vec<_>>()
    };
    // Same limits at both, 16 rad/s of which the knee may do 16.67: nobody knows, so it is no error.
    assert_eq!(found(16.0, 16.0), Vec::<String>::new());
    assert_eq!(found(24.0, 10.0), Vec::<String>::new());
    assert_eq!(found(26.5, 10.0), ["GW403"]);
    assert_eq!(found(1146.0, 10.0), ["GW403"]);
}

/// A joint whose r goes with the angle is judged by itself, whatever its neighbour carries.
#[test]
fn what_is_too_fast_behind_a_lever_is_found_next_to_a_joint_of_the_same_limits() {
    let hardware = of_all("ankle").replace("names = [\"*\"]", "names = [\"a\"]")
        + &of_all("ankle").replace("names = [\"*\"]", "names = [\"b\"]")
        + "transmission = { lever = { pivot = [\"0 mm\", \"180 mm\"], arm = \"50 mm\", lead = \"5 mm\" }, range = [\"-0.5 rad\", \"0.5 rad\"] }\n";
    let at = folder(&hardware, &[]);
    let limits = "effort=\"50\" velocity=\"37\"";
    fs::write(at.path().join("m.urdf"), urdf(&[("a", limits), ("b", limits)])).unwrap();
    let ran = run(&at, &["m.urdf"]);
    assert!(ran.out.contains("GW403") && ran.status == 1, "{}{}", ran.out, ran.err);
    let other = at.path().join("hardware.toml");
    let upside_down = hardware.replace("[\"-0.5 rad\", \"0.5 rad\"]", "[\"0.5 rad\", \"-0.5 rad\"]");
    for (text, said) in [
        (upside_down, "upside down"),
        (hardware.replace(", range = [\"-0.5 rad\", \"0.5 rad\"]", ""), "range"),
        (hardware.replace("\"0.5 rad\"]", "\"1.8 rad\"]"), "no torque reaches"),
    ] {
        fs::write(&other, text).unwrap();
        let ran = run(&at, &["m.urdf"]);
        assert!(ran.status == 2 && ran.err.contains(said), "{said}: {}{}", ran.out, ran.err);
    }
}
