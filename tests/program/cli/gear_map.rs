//! A family of gears as a map over the ratio: every mistake of its file and of what goes with it, and the commands that
//! answer with it.

use std::fs;

use serde_json::Value;

use super::folder::{REQUIREMENT, Ran, folder, run};
use super::tables::collapsed;

/// A planetary family: one stage up to 10, two from there on.
const MAP: &str = "ratio, efficiency, mass [g], inertia [g*cm^2], peak_torque [N*m], max_input_speed [rpm]
3,  0.96, 120, 0.30, 12, 9000
6,  0.95, 130, 0.20, 11, 9000
10, 0.92, 140, 0.15, 9,  9000
10, 0.91, 220, 0.25, 14, 9000
30, 0.86, 240, 0.15, 12, 9000
";

const GEAR: &str = "gear = { efficiency = 0.95, mass = \"150 g\", inertia = \"2e-6 kg*m^2\" }";

/// The command in a folder whose joint has a map, with some of its files spoilt.
fn with(map: &str, changes: &[(&str, &str)], words: &[&str]) -> Ran {
    let folder = folder();
    let mut text = REQUIREMENT.replace(GEAR, "gear = { map = \"planetary.csv\" }");
    for (from, to) in changes {
        assert!(text.contains(from), "`{from}` is not in the requirement");
        text = text.replacen(from, to, 1);
    }
    fs::write(folder.path().join("robot.toml"), text).unwrap();
    fs::write(folder.path().join("planetary.csv"), map).unwrap();
    run(&folder, words)
}

const OPTIMIZE: &[&str] = &["optimize", "robot.toml", "--catalog", "motors.csv"];

fn json(ran: &Ran) -> Value {
    serde_json::from_str(&ran.out).unwrap_or_else(|e| panic!("{e}: {}{}", ran.out, ran.err))
}

#[test]
fn every_mistake_of_a_map_has_its_place() {
    let row = |from: &str, to: &str| MAP.replacen(from, to, 1);
    let cases: &[(&str, String, &[&str])] = &[
        ("empty", String::new(), &["planetary.csv:1", "the file is empty"]),
        ("header alone", MAP.lines().next().unwrap().into(), &["planetary.csv:1", "a header but no rows"]),
        ("one row", MAP.lines().take(2).collect::<Vec<_>>().join("\n"), &["planetary.csv:2:1", "the map has one row"]),
        ("falling", row("6,  0.95", "2,  0.95"), &["planetary.csv:3:1", "the ratios do not rise: 2 in row 2 after 3"]),
        (
            "nearly one ratio",
            row("10, 0.91", "10.000001, 0.91"),
            &["planetary.csv:5:1", "nearly that of the row above"],
        ),
        (
            "three of a ratio",
            row("30, 0.86", "10, 0.86") + "30,0.8,240,0.1,12,9000\n",
            &["planetary.csv:6:1", "three times"],
        ),
        ("begins with a jump", row("6,  0.95", "3,  0.95"), &["planetary.csv:3:1", "begins with a jump"]),
        (
            "ends with a jump",
            row("30, 0.86", "10.0, 0.86").replacen("10, 0.92", "9, 0.92", 1),
            &["planetary.csv:6:1", "ends with a jump"],
        ),
        (
            "an efficiency above one",
            row("0.95", "1.05"),
            &["planetary.csv:3:5", "`efficiency` is out of range", "greater than 0 and at most 1"],
        ),
        ("an efficiency of nothing", row("0.95", "0"), &["planetary.csv:3:5", "`efficiency` is out of range"]),
        ("not a number", row("0.95", "nan"), &["planetary.csv:3:5", "`efficiency`"]),
        ("a missing cell", row("6,  0.95,", "6,  ,"), &["planetary.csv:3", "`efficiency` is missing in row 2"]),
        ("a wrong unit", row("[g*cm^2]", "[g]"), &["planetary.csv:1", "column `inertia`"]),
        ("no unit", row("mass [g]", "mass"), &["planetary.csv:1", "column `mass`"]),
        (
            "an unknown column",
            row("peak_torque [N*m]", "peak_torqe [N*m]"),
            &["planetary.csv:1", "unknown column `peak_torqe`", "peak_torque"],
        ),
        (
            "a size",
            row("peak_torque [N*m]", "length [mm]"),
            &["planetary.csv:1", "column `length`", "nothing is computed with it"],
        ),
        ("the ratio alone", "ratio\n3\n30\n".into(), &["planetary.csv:1", "says nothing but the ratio"]),
        ("no ratio", row("ratio,", "mass_of,"), &["planetary.csv:1", "unknown column `mass_of`"]),
        (
            "a backdrive efficiency above one",
            MAP.replacen("efficiency,", "backdrive_efficiency,", 1).replace("0.95", "1.5"),
            &["planetary.csv:3:5", "`backdrive_efficiency` of 1.5 is out of range in row 2"],
        ),
        (
            "a catalogue of gears",
            "id,kind,ratio,efficiency,source,source_kind\na,planetary,5,0.9,a,datasheet\n".into(),
            &["a catalogue of gears", "a gear map"],
        ),
    ];
    for (name, map, says) in cases {
        let ran = with(map, &[], OPTIMIZE);
        assert_eq!((ran.status, ran.out.as_str()), (2, ""), "{name}: {}", ran.err);
        for what in *says {
            assert!(collapsed(&ran.err).contains(what), "{name}: `{what}` is not in\n{}", ran.err);
        }
    }
}

/// What is refused: its name, what is put in place of what in the requirement, and what the report says.
type Refused = (&'static str, &'static [(&'static str, &'static str)], &'static [&'static str]);

#[test]
fn what_does_not_go_with_a_map_is_refused_with_its_place() {
    let cases: &[Refused] = &[
        (
            "beyond the map",
            &[("max = 30", "max = 31")],
            &["robot.toml:9", "the ratios go from 3 to 31, the gear's `map` from 3 to 30", "narrow `ratio`"],
        ),
        ("below the map", &[("min = 3", "min = 2")], &["robot.toml:9", "from 2 to 30"]),
        (
            "a listed ratio outside",
            &[("{ min = 3, max = 30 }", "{ values = [2, 5] }")],
            &["robot.toml:9", "from 2 to 5"],
        ),
        (
            "a key that it gives",
            &[("map = \"planetary.csv\"", "map = \"planetary.csv\", efficiency = 0.9")],
            &["robot.toml:11", "`efficiency` of [gear] and the column `efficiency` of its `map` say one thing"],
        ),
        (
            "a mass by stages",
            &[("map = \"planetary.csv\"", "map = \"planetary.csv\", mass_per_stage = \"90 g\", stage_ratio = 5")],
            &["robot.toml:11", "`mass_per_stage` of [gear] and the column `mass`"],
        ),
        (
            "no such file",
            &[("map = \"planetary.csv\"", "map = \"none.csv\"")],
            &["robot.toml:11", "gear map `none.csv`"],
        ),
        (
            "gears of the catalogue",
            &[("ratio = { min = 3, max = 30 }", "gears = [\"*\"]")],
            &["robot.toml:11", "`gears` takes them from the catalogue"],
        ),
        (
            "a spring",
            &[(
                "[joint.limits]",
                "[joint.limits]\nspring = { stiffness = [\"0 N*m/rad\", \"4 N*m/rad\"], rest_angle = [\"0 deg\", \"5 deg\"] }",
            )],
            &["robot.toml:11", "a spring is not chosen together with a gear `map`"],
        ),
        (
            "a torque that backdrives",
            &[("[joint.limits]", "[joint.limits]\nmax_backdriving_torque = \"1 N*m\"")],
            &["robot.toml:14", "`max_backdriving_torque` is not judged"],
        ),
        (
            "a budget of power",
            &[("[[joint]]", "[budget]\npower = \"90 W\"\n[[joint]]")],
            &["robot.toml:8", "joint `knee` has a gear `map` and shares a budget of power"],
        ),
    ];
    for (name, changes, says) in cases {
        let ran = with(MAP, changes, OPTIMIZE);
        assert_eq!((ran.status, ran.out.as_str()), (2, ""), "{name}: {}", ran.err);
        for what in *says {
            assert!(collapsed(&ran.err).contains(what), "{name}: `{what}` is not in\n{}", ran.err);
        }
    }
    let map = MAP.replace("max_input_speed [rpm]", "continuous_torque [N*m]").replace("9000", "8");
    let life = "[joint.limits]\nlife = \"9000 h\"";
    let ran = with(&map, &[("[joint.limits]", life)], OPTIMIZE);
    assert!(ran.status == 2 && collapsed(&ran.err).contains("`life` is not judged"), "{}", ran.err);
}

/// A ratio that the map does not cover has no answer, in any command that takes one.
#[test]
fn a_ratio_outside_the_map_is_not_answered() {
    let narrow = [("max = 30", "max = 20")];
    let map = MAP.replace("30, 0.86", "20, 0.86");
    let commands: [(&[&str], i32); 3] = [
        (&["explain", "alpha-1@25", "robot.toml", "--catalog", "motors.csv"], 2),
        (&["export", "alpha-1@25", "robot.toml", "--to", "mjcf", "--catalog", "motors.csv"], 2),
        (&["explain", "alpha-1@2.9", "robot.toml", "--catalog", "motors.csv"], 2),
    ];
    for (words, status) in commands {
        let ran = with(&map, &narrow, words);
        assert_eq!((ran.status, ran.out.as_str()), (status, ""), "{words:?}: {}", ran.err);
        assert!(
            collapsed(&ran.err).contains("the gear's `map` or family says nothing of this ratio"),
            "{words:?}: {}",
            ran.err
        );
        let there = words[1].replace("25", "18").replace("2.9", "3.1");
        let inside: Vec<&str> =
            words.iter().map(|word| if *word == words[1] { there.as_str() } else { word }).collect();
        let ran = with(&map, &narrow, &inside);
        assert!(ran.status < 2 && !ran.out.is_empty(), "{inside:?}: {}", ran.err);
    }
}

/// A figure of an explanation.
fn explained(ran: &Ran, key: &str) -> f64 {
    let story = json(ran);
    let found = ["design", "evaluation"].iter().find_map(|at| story["joints"][0][at][key].as_f64());
    found.or_else(|| story["joints"][0][key].as_f64()).unwrap_or_else(|| panic!("no {key} in {story}"))
}

/// Between two rows the gear is that which keys of `[joint.gear]` say with the interpolated numbers: in `explain`, and in
/// `optimize` of that ratio alone.
#[test]
fn between_its_rows_a_map_is_the_plain_gear() {
    // From the second row of ratio 10 to 30: N² goes 0.375 of the way, 1/N² 0.84375 of it.
    let efficiency = 1.0 / (1.0 / 0.91 + 0.375 * (1.0 / 0.86 - 1.0 / 0.91));
    let key = format!(
        "gear = {{ efficiency = {efficiency}, mass = \"227.5 g\", inertia = \"0.165625 g*cm^2\", peak_torque = \"13.25 N*m\", max_input_speed = \"9000 rpm\" }}"
    );
    let plain = [("gear = { map = \"planetary.csv\" }", key.as_str())];
    let alone = [("{ min = 3, max = 30 }", "{ values = [20] }")];
    for objective in ["loss", "mass", "reflected_inertia", "energy"] {
        let of = ("objective = \"loss\"", format!("objective = \"{objective}\""));
        let of = [(of.0, of.1.as_str())];
        let words = [OPTIMIZE, &["--json"]].concat();
        let best = |changes: &[(&str, &str)]| {
            let ran = with(MAP, changes, &words);
            assert_eq!(ran.status, 0, "{}", ran.err);
            json(&ran)["joints"][0]["candidates"].clone()
        };
        let (map, keys) = (best(&[&alone[..], &of].concat()), best(&[&plain[..], &alone, &of].concat()));
        assert!(map.as_array().is_some_and(|list| !list.is_empty()), "{map}");
        for (a, b) in map.as_array().unwrap().iter().zip(keys.as_array().unwrap()) {
            for figure in ["objective", "loss_w", "mass_kg", "reflected_inertia_kgm2", "copper_loss_w"] {
                let (x, y) = (a[figure].as_f64(), b[figure].as_f64());
                let near = x.zip(y).is_none_or(|(x, y)| (x - y).abs() <= 1e-9 * x.abs());
                assert!(near && x.is_some() == y.is_some(), "{objective}, {figure}: {x:?} {y:?}");
            }
        }
    }
    let words = ["explain", "alpha-1@20", "robot.toml", "--catalog", "motors.csv", "--json"];
    let (map, keys) = (with(MAP, &[], &words), with(MAP, &plain, &words));
    for figure in ["loss_w", "reflected_inertia_kgm2"] {
        let (x, y) = (explained(&map, figure), explained(&keys, figure));
        assert!((x - y).abs() <= 1e-9 * x.abs(), "{figure}: {x} {y}");
    }
}

/// Every command that chooses or evaluates has an answer with a map, and the best ratio is proved.
#[test]
fn commands_answer_with_a_map() {
    let ran = with(MAP, &[], &[OPTIMIZE, &["--json"]].concat());
    assert_eq!(ran.status, 0, "{}", ran.err);
    let best = json(&ran)["joints"][0]["candidates"][0].clone();
    assert_eq!(best["certificate"]["certified"], Value::Bool(true), "{best}");
    assert!((3.0..=30.0).contains(&best["ratio"].as_f64().unwrap()));
    for words in [
        &["sweep", "robot.toml", "--catalog", "motors.csv"][..],
        &["optimize", "robot.toml", "--catalog", "motors.csv", "--pareto", "loss,mass"],
        &["optimize", "robot.toml", "--catalog", "motors.csv", "--robust", "--tolerance", "5%"],
        &["optimize", "robot.toml", "--catalog", "motors.csv", "--why", "--rejected", "--full"],
        &["optimize", "robot.toml", "--catalog", "motors.csv", "--html", "page.html"],
        &["explain", "alpha-1", "robot.toml", "--catalog", "motors.csv", "--plot", "a.svg"],
        &["export", "alpha-1@9", "robot.toml", "--catalog", "motors.csv", "--to", "mjcf"],
        &["check", "design.toml"],
    ] {
        let ran = with(MAP, &[], words);
        assert!(ran.status <= 1 && !ran.err.contains("panicked"), "{words:?}: {}{}", ran.out, ran.err);
    }
}
