//! Designs handed over to simulators, as a user sees them. That a simulator then moves as the model says is
//! tested in MuJoCo itself (tests/external/mujoco_export.py).

use std::path::Path;

use approx::assert_relative_eq;
use roxmltree::Document;
use serde_json::Value;

use crate::common::run::{gearwise, stderr, stdout};

const ROBOT: &str = "requirements/quadruped_mini_cheetah.toml";

fn write(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_string()
}

/// A motor whose every number is chosen, through a gear whose every number is chosen.
fn worked_example(folder: &Path, joint: &str) -> [String; 2] {
    let motors = "id,terminals,current,resistance [ohm],inductance [mH],torque_constant [N*m/A],rotor_inertia [kg*m^2],\
                  mass [kg],pole_pairs,continuous_current [A],peak_current [A],max_speed [rad/s],\
                  coulomb_friction [N*m],viscous_friction [N*m*s/rad],source,source_kind\n\
                  m,q_axis,q_axis,0.5,0,0.1,2e-5,0.3,7,5,20,500,0.01,1e-4,a & <b> -- c,derived\n";
    let robot = format!(
        "name = \"x\"\nbus = {{ voltage = \"48 V\", drive_current = \"100 A\" }}\n[[joint]]\nname = {}\n\
         ratio = {{ min = 3, max = 30 }}\ngear = {{ efficiency = 0.8, inertia = \"1e-5 kg*m^2\", peak_torque = \"18 N*m\" }}\n\
         points = [ {{ torque = \"2 N*m\", speed = \"3 rad/s\", duration = \"1 s\" }} ]\n",
        toml::Value::String(joint.into())
    );
    [write(folder, "motors.csv", motors), write(folder, "robot.toml", &robot)]
}

fn attribute(document: &Document, tag: &str, name: &str) -> f64 {
    let value = document.descendants().find_map(|n| n.attribute(name).filter(|_| n.has_tag_name(tag)));
    value.unwrap_or_else(|| panic!("<{tag} {name}>")).parse().unwrap()
}

fn range(document: &Document, tag: &str, name: &str) -> [f64; 2] {
    let node = document.descendants().find(|n| n.has_tag_name(tag) && n.has_attribute(name)).unwrap();
    let values: Vec<f64> = node.attribute(name).unwrap().split(' ').map(|v| v.parse().unwrap()).collect();
    [values[0], values[1]]
}

#[test]
fn the_numbers_are_those_on_paper() {
    let folder = tempfile::tempdir().unwrap();
    let [motors, robot] = worked_example(folder.path(), "j");
    let run = |to: &str| stdout(&gearwise(&["export", "m@10", &robot, "--catalog", &motors, "--to", to]));
    let mjcf = run("mjcf");
    let document = Document::parse(&mjcf).unwrap();
    // N²(J_m + J_g) = 100 · 3e-5; N² b; N c.
    assert_relative_eq!(attribute(&document, "joint", "armature"), 3e-3, max_relative = 1e-12);
    assert_relative_eq!(attribute(&document, "joint", "damping"), 1e-2, max_relative = 1e-12);
    assert_relative_eq!(attribute(&document, "joint", "frictionloss"), 0.1, max_relative = 1e-12);
    assert_eq!(attribute(&document, "motor", "gear"), 10.0);
    // The motor gives 2 N*m = 0.1 · 20 and 20 N*m at the output, the gear carries 18.
    for name in ["ctrlrange", "forcerange"] {
        let [low, high] = range(&document, "motor", name);
        assert_relative_eq!(high, 1.8, max_relative = 1e-12);
        assert_eq!(low, -high);
    }
    assert_relative_eq!(range(&document, "joint", "actuatorfrcrange")[1], 18.0, max_relative = 1e-12);
    for said in [
        "velocity limit 33.94 rad/s (by the voltage without load)",
        "gear efficiency 0.8, backwards 0.75",
        "14.4 N*m reach",
    ] {
        assert!(mjcf.contains(said), "{said}:\n{mjcf}");
    }

    let urdf = run("urdf");
    let document = Document::parse(&urdf).unwrap();
    assert_relative_eq!(attribute(&document, "limit", "effort"), 18.0, max_relative = 1e-12);
    // 48/√2 V over 0.1 V·s/rad, over ten; the motor's 500 rad/s allow more. Twelve digits are written.
    assert_relative_eq!(attribute(&document, "limit", "velocity"), 48.0 / 2.0_f64.sqrt(), max_relative = 1e-11);
    assert_relative_eq!(attribute(&document, "dynamics", "damping"), 1e-2, max_relative = 1e-12);
    assert_relative_eq!(attribute(&document, "dynamics", "friction"), 0.1, max_relative = 1e-12);
    let inside = |tag: &str| document.descendants().find(|n| n.tag_name().name() == tag).unwrap();
    assert_eq!(inside("mechanicalReduction").text(), Some("10"));
    assert_eq!(inside("gear_ratio").attribute("value"), Some("10"));
    let rotor: f64 = inside("rotor_inertia").attribute("value").unwrap().parse().unwrap();
    assert_relative_eq!(rotor * 100.0, 3e-3, max_relative = 1e-12);
    assert!(urdf.contains("armature 0.003"), "{urdf}");

    let json: Value = serde_json::from_str(&run("json")).unwrap();
    let joint = &json["joints"][0];
    let is =
        |key: &str, expected: f64| assert_relative_eq!(joint[key].as_f64().unwrap(), expected, max_relative = 1e-12);
    is("armature_kgm2", 3e-3);
    is("damping_nms_per_rad", 1e-2);
    is("friction_loss_nm", 0.1);
    is("effort_nm", 18.0);
    // 5 A · 0.1 N*m/A · 10.
    is("continuous_effort_nm", 5.0);
    is("motor_torque_nm", 1.8);
    // 18 A: V = 33.94 = R · 18 + 0.1 ω, R of the winding at 100 °C, which is assumed: 0.5 ohm are those at 25 °C.
    let hot = 1.0 + 0.00393 / (1.0 + 0.00393 * 5.0) * 75.0;
    is("velocity_at_effort_rad_per_s", (48.0 / 2.0_f64.sqrt() - 0.5 * hot * 18.0) / 0.1 / 10.0);
    // With 0.1 ohm of drive and leads, and a supply of 0.2 ohm that sags: 48 V = V + 0.2 P/V at the voltage V/√2 that this speed takes.
    let sagging = "bus.drive_phase_resistance=0.1 ohm";
    let set = ["--set", sagging, "--set", "bus.internal_resistance=0.2 ohm"];
    let arguments = [&["export", "m@10", &robot, "--catalog", &motors, "--to", "json"][..], &set[..]].concat();
    let json: Value = serde_json::from_str(&stdout(&gearwise(&arguments))).unwrap();
    let speed = 10.0 * json["joints"][0]["velocity_at_effort_rad_per_s"].as_f64().unwrap();
    let resistance = 0.5 * hot + 0.1;
    let (bus, power) =
        ((resistance * 18.0 + 0.1 * speed) * 2.0_f64.sqrt(), resistance * 18.0 * 18.0 + 0.1 * speed * 18.0);
    assert_relative_eq!(bus + 0.2 * power / bus, 48.0, max_relative = 1e-9);
    assert_eq!(joint["effort_by"], "gear");
    assert_eq!(joint["feasible"], true);
    assert_eq!(json["requirement"], "robot.toml");
    assert_eq!(json["requirement_sha256"].as_str().unwrap().len(), 64);
}

#[test]
fn what_is_not_known_is_not_zero() {
    let run = |to| stdout(&gearwise(&["export", "t-motor-ri50@9", ROBOT, "--joint", "knee", "--to", to]));
    let json: Value = serde_json::from_str(&run("json")).unwrap();
    let joint = &json["joints"][0];
    assert!(joint["damping_nms_per_rad"].is_null() && joint["friction_loss_nm"].is_null());
    let left_out = joint["left_out"].to_string();
    assert!(left_out.contains("viscous friction") && left_out.contains("is not known"), "{left_out}");
    for format in ["mjcf", "urdf"] {
        let text = run(format);
        let document = Document::parse(&text).unwrap();
        let has = |name: &str| document.descendants().any(|n| n.has_attribute(name));
        assert!(!has("damping") && !has("frictionloss") && !has("friction"), "{text}");
        assert!(text.contains("left out: Coulomb friction"), "{text}");
    }
}

#[test]
fn effects_go_where_they_say_or_into_the_comments() {
    let folder = tempfile::tempdir().unwrap();
    let [_, robot] = worked_example(folder.path(), "j");
    let fitted = "gearwise = \"0.1.0\"\n[motor]\nid = \"f\"\nterminals = \"q_axis\"\ncurrent = \"q_axis\"\n\
                  resistance = \"0.5 ohm\"\ntorque_constant = \"0.1 N*m/A\"\nrotor_inertia = \"2e-5 kg*m^2\"\n\
                  peak_current = \"20 A\"\nviscous_friction = \"1e-4 N*m*s/rad\"\nsource = \"s\"\nsource_kind = \"measured\"\n\
                  [effects.coulomb_friction]\ntorque = \"0.02 N*m\"\n\
                  [effects.stribeck_friction]\ntorque = \"0.01 N*m\"\nspeed = \"8 rad/s\"\n\
                  [effects.gear_compliance]\ncompliance = \"1e-3 rad/(N*m)\"\n\
                  [[provenance]]\nlog = \"run.csv\"\nsha256 = \"00ff\"\nuse = \"fit\"\n";
    let fitted = write(folder.path(), "fitted.toml", fitted);
    let text = stdout(&gearwise(&["export", "f@10", &robot, "--catalog", &fitted, "--to", "mjcf"]));
    let document = Document::parse(&text).unwrap();
    assert_relative_eq!(attribute(&document, "joint", "frictionloss"), 0.2, max_relative = 1e-12);
    assert_relative_eq!(attribute(&document, "joint", "damping"), 1e-2, max_relative = 1e-12);
    for said in [
        "left out: stribeck_friction: c_s exp",
        "a stiffness of 1000 N*m/rad between motor and output",
        "fitted from run.csv, SHA-256 00ff",
    ] {
        assert!(text.contains(said), "{said}:\n{text}");
    }
}

#[test]
fn names_are_escaped_and_comments_end_where_they_should() {
    let folder = tempfile::tempdir().unwrap();
    let name = "a\"<script>&'--";
    let [motors, robot] = worked_example(folder.path(), name);
    for to in ["mjcf", "urdf"] {
        let text = stdout(&gearwise(&["export", "m@10", &robot, "--catalog", &motors, "--to", to]));
        let document = Document::parse(&text).unwrap_or_else(|e| panic!("{to}: {e}\n{text}"));
        let names: Vec<&str> = document.descendants().filter_map(|n| n.attribute("name")).collect();
        assert!(names.contains(&name), "{names:?}");
        assert!(document.descendants().all(|n| n.tag_name().name() != "script"));
    }
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    for to in ["mjcf", "urdf", "json"] {
        let run = |threads| {
            gearwise(&["export", "t-motor-ri50", ROBOT, "--joint", "knee", "--to", to, "--threads", threads]).stdout
        };
        assert!(!run("1").is_empty());
        assert_eq!(run("1"), run("3"));
    }
}

const MODEL: &str = r#"<?xml version="1.0"?>
<!-- a leg -->
<mujoco model="leg">
  <worldbody>
    <body name="thigh">
      <joint name="left_knee" axis="0 1 0" damping="7"/>   <!-- keep this -->
      <geom size="0.1"/>
      <body><joint name="right_knee"/><geom size="0.1"/></body>
      <body><joint name="ankle" armature="0.5"/><geom size="0.1"/></body>
    </body>
  </worldbody>
  <actuator>
    <motor name="drive" joint="left_knee" gear="1"/>
  </actuator>
</mujoco>
"#;

#[test]
fn a_model_is_patched_where_it_should_and_stays_as_it_is_elsewhere() {
    let folder = tempfile::tempdir().unwrap();
    let [motors, robot] = worked_example(folder.path(), "knee");
    let model = write(folder.path(), "model.xml", MODEL);
    let run = |model: &str, map: &str| {
        gearwise(&["export", "m@10", &robot, "--catalog", &motors, "--into", model, "--map", map])
    };
    let output = run(&model, "knee=*_knee");
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let text = stdout(&output);
    let document = Document::parse(&text).unwrap();
    let joint = |name: &str| {
        document.descendants().find(|n| n.has_tag_name("joint") && n.attribute("name") == Some(name)).unwrap()
    };
    for name in ["left_knee", "right_knee"] {
        assert_eq!(joint(name).attribute("armature"), Some("0.003"), "{text}");
        assert_eq!(joint(name).attribute("damping"), Some("0.01"));
        let motors: Vec<_> =
            document.descendants().filter(|n| n.has_tag_name("motor") && n.attribute("joint") == Some(name)).collect();
        assert_eq!(motors.len(), 1, "{text}");
        assert_eq!(motors[0].attribute("gear"), Some("10"));
    }
    assert_eq!(joint("ankle").attribute("armature"), Some("0.5"));
    assert!(text.contains("/>   <!-- keep this -->") && text.contains("<!-- a leg -->"), "{text}");
    assert_eq!(joint("left_knee").attribute("axis"), Some("0 1 0"));
    // Once more into the result: nothing changes.
    let again = write(folder.path(), "again.xml", &text);
    assert_eq!(stdout(&run(&again, "knee=*_knee")), text);

    let urdf = "<robot name=\"r\">\n  <link name=\"a\"/>\n  <link name=\"b\"/>\n  <joint name=\"knee\" type=\"revolute\">\n    \
                <parent link=\"a\"/><child link=\"b\"/>\n    <limit lower=\"-1\" upper=\"1\" effort=\"3\" velocity=\"4\"/>\n  </joint>\n</robot>\n";
    let urdf = write(folder.path(), "robot.urdf", urdf);
    let export = |model: &str| stdout(&gearwise(&["export", "m@10", &robot, "--catalog", &motors, "--into", model]));
    let text = export(&urdf);
    let document = Document::parse(&text).unwrap();
    assert_eq!(attribute(&document, "limit", "lower"), -1.0);
    assert_relative_eq!(attribute(&document, "limit", "effort"), 18.0, max_relative = 1e-12);
    assert_relative_eq!(attribute(&document, "dynamics", "friction"), 0.1, max_relative = 1e-12);
    assert!(document.descendants().any(|n| n.tag_name().name() == "mechanicalReduction" && n.text() == Some("10")));
    let again = write(folder.path(), "again.urdf", &text);
    assert_eq!(export(&again), text);
}

#[test]
fn wrong_inputs_say_what_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    let [motors, robot] = worked_example(folder.path(), "knee");
    let model = write(folder.path(), "model.xml", MODEL);
    let broken = write(folder.path(), "broken.xml", "<mujoco><a></mujoco>");
    let html = write(folder.path(), "page.html", "<html/>");
    let nowhere = folder.path().join("no/such/folder/x.xml");
    let base = ["export", "m@10", robot.as_str(), "--catalog", motors.as_str()];
    for (more, expected) in [
        (vec!["--to", "mjfc"], "similar value exists: 'mjcf'"),
        (vec!["--to", "mjcf", "--joint", "kne"], "did you mean `knee`?"),
        (vec![], "--to <FORMAT>"),
        (vec!["--into", &model], "no joint matches `knee`"),
        (vec!["--into", &model, "--map", "knee"], "expected JOINT=PATTERN"),
        (vec!["--into", &model, "--map", "knie=*_knee"], "did you mean `knee`?"),
        (vec!["--into", &broken], "not XML"),
        (vec!["--into", &html], "expected <mujoco> (MJCF), <robot> (URDF) or <sdf> (SDFormat)"),
        (vec!["--to", "mjcf", "--out", nowhere.to_str().unwrap()], "cannot write"),
        (vec!["--to", "mjcf", "--out", folder.path().to_str().unwrap()], "it is a folder"),
    ] {
        let arguments: Vec<&str> = base.iter().copied().chain(more.iter().copied()).collect();
        let output = gearwise(&arguments);
        assert_eq!(output.status.code(), Some(2), "{more:?}");
        assert!(output.stdout.is_empty(), "{more:?}");
        assert!(stderr(&output).contains(expected), "{more:?}: {}", stderr(&output));
    }
    // A motor without rotor inertia has no armature.
    let output = gearwise(&["export", "cubemars-ro100-kv55@9", ROBOT, "--joint", "knee", "--to", "mjcf"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("its rotor inertia is not known"), "{}", stderr(&output));
    // A design that is not feasible is exported, and says so.
    let output = gearwise(&["export", "t-motor-ri50@30", ROBOT, "--joint", "knee", "--to", "mjcf"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("is not feasible, it breaks voltage"), "{}", stderr(&output));
    assert!(stdout(&output).contains("NOT FEASIBLE: breaks voltage") && Document::parse(&stdout(&output)).is_ok());
}

#[test]
fn an_output_file_says_what_was_written() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("knee.xml");
    let arguments = ["export", "t-motor-ri50@9", ROBOT, "--joint", "knee", "--to", "mjcf"];
    let plain = stdout(&gearwise(&arguments));
    let output = gearwise(&[&arguments[..], &["--out", out.to_str().unwrap()]].concat());
    assert_eq!(std::fs::read_to_string(&out).unwrap(), plain);
    assert!(stdout(&output).starts_with("knee: t-motor-ri50 at N = 9, armature "), "{}", stdout(&output));
}

#[test]
fn a_design_file_exports_all_its_joints() {
    let folder = tempfile::tempdir().unwrap();
    let [motors, _] = worked_example(folder.path(), "j");
    let motion =
        "time [s],torque [N*m],velocity [rad/s],position [rad]\n0,1,0,0\n1,1,1,0.5\n2,1,0,1\n3,1,-1,0.5\n4,1,0,0\n";
    write(folder.path(), "swing.csv", motion);
    let joint = |name: &str, more: &str| {
        format!("[[joint]]\nname = \"{name}\"\nratio = {{ min = 3, max = 30 }}\nmotion = \"swing.csv\"\n{more}")
    };
    let spring = "spring = { stiffness = [\"0 N*m/rad\", \"9 N*m/rad\"], rest_angle = [\"-1 rad\", \"1 rad\"] }\n";
    let robot = format!("name = \"x\"\nbus = {{ voltage = \"48 V\" }}\n{}{}", joint("hip", spring), joint("knee", ""));
    write(folder.path(), "robot.toml", &robot);
    let design = format!(
        "requirement = \"robot.toml\"\ncatalog = [{}]\n[[joint]]\nname = \"hip\"\nmotor = \"m\"\nratio = 6.0\n\
         spring = {{ stiffness = \"4 N*m/rad\", rest_angle = \"0.5 rad\" }}\n[[joint]]\nname = \"knee\"\nmotor = \"m\"\nratio = 9.0\n",
        toml::Value::String(motors)
    );
    let design = write(folder.path(), "design.toml", &design);
    let output = gearwise(&["export", &design, "--to", "json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    let armature = |k: usize| json["joints"][k]["armature_kgm2"].as_f64().unwrap();
    assert_relative_eq!(armature(0), 36.0 * 2e-5, max_relative = 1e-12);
    assert_relative_eq!(armature(1), 81.0 * 2e-5, max_relative = 1e-12);
    assert_eq!(json["design"], "design.toml");
    assert!(
        json["joints"][0]["left_out"].to_string().contains("parallel spring of 4 N*m/rad with its rest at 0.5 rad")
    );
    let one = stdout(&gearwise(&["export", &design, "--to", "mjcf", "--joint", "knee"]));
    assert!(one.contains("knee_actuator") && !one.contains("hip_actuator"));
    // A joint that is not there, a motor where a design is expected.
    let wrong = gearwise(&["export", &design, "--to", "mjcf", "--joint", "kneee"]);
    assert!(wrong.status.code() == Some(2) && stderr(&wrong).contains("did you mean `knee`?"));
    let wrong = gearwise(&["export", "m@9", "--to", "mjcf"]);
    assert!(wrong.status.code() == Some(2) && stderr(&wrong).contains("a motor needs its requirement"));
}
