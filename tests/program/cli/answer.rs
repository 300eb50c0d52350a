//! What `optimize` prints first: every choice on one screen, at every width, compared with the JSON of the same run; then why.
//! And ratios that are listed, in every command.

use std::process::Command;

use gearwise::report::{number, number_between};
use serde_json::Value;

use super::tables::{
    Folder, OBJECTIVES, WIDTHS, assert_nothing_folded, assert_width, collapsed, left_out, ratio_of, rows_of, shown,
    text_of, tightest,
};
use crate::cases::few;

/// Legs with wide limits and one objective, or none.
fn legs(folder: &Folder, name: &str, objective: Option<&str>, more: &[(&str, &str)]) {
    let objective = objective.map_or_else(String::new, |o| format!("objective = {o}"));
    let wide = [
        ("objective = \"loss\"", &*objective),
        ("actuator_mass = \"0.55 kg\"\n", ""),
        ("\"0.01 kg*m^2\"", "\"0.05 kg*m^2\""),
    ];
    folder.requirement("quadruped_mini_cheetah.toml", name, &[&wide[..], more].concat());
}

fn all(value: &Value) -> &Vec<Value> {
    value.as_array().unwrap()
}

#[test]
fn every_choice_stands_on_the_first_screen_at_every_width() {
    let folder = Folder::new();
    let objectives = OBJECTIVES.iter().map(|o| Some(*o)).chain([None]);
    for (k, objective) in few(2, objectives.enumerate()) {
        let file = format!("legs_{k}.toml");
        legs(&folder, &file, objective, &[]);
        let words = ["optimize", &file, "--catalog", "catalog"];
        let json = folder.json(&words);
        for width in WIDTHS {
            let what = format!("{objective:?} at {width:?}");
            let text = folder.run(&words, width);
            assert_width(&text, width.unwrap_or(120), &what);
            let (dropped, text) = left_out(&text);
            let key = |j: &Value| {
                let first = &j["candidates"][0];
                vec![("motor", text_of(&first["motor"])), ("N", ratio_of(first))]
            };
            let keys: Vec<_> = all(&json["joints"]).iter().map(key).collect();
            for (row, joint) in rows_of(&text, &keys, &what).iter().zip(all(&json["joints"])) {
                let first = &joint["candidates"][0];
                let (limit, margin) = tightest(&first["margins"]);
                let said = format!("smallest margin {limit} {:.0} %", (100.0 * margin).max(0.0));
                assert!(row.contains(&said), "{what}: {said} in\n{row}");
                for (heading, key) in [("mass", "mass_kg"), ("copper loss", "loss_w")] {
                    let cell = format!(" {} ", shown(&first[key]));
                    assert!(row.contains(&cell) || dropped.contains(&heading.into()), "{what}: {heading} in\n{row}");
                }
                let unchecked = all(&first["not_checked"]).len();
                assert_eq!(row.contains("not checked"), unchecked > 0, "{what}:\n{row}");
                let estimated = !all(&first["estimated"]).is_empty();
                assert_eq!(row.contains("estimated:"), estimated, "{what}:\n{row}");
                assert_eq!(row.contains("not certified"), first["certificate"]["certified"] == false, "{what}:\n{row}");
                // That the own bound decides is said where it does.
                assert_eq!(
                    row.contains("your own bound on the ratio decides"),
                    joint["own_bound"].is_object(),
                    "{what}:\n{row}"
                );
            }
            for joint in all(&json["joints"]) {
                for end in ["lightest", "least_loss"] {
                    let Some(end) = joint["choices"].get(end) else { continue };
                    assert!(text.contains(&format!(" {} ", end["motor"].as_str().unwrap())), "{what}: {end}");
                    assert!(text.contains(&format!(" {} ", shown(&end["loss_w"]))), "{what}: {end}");
                }
            }
        }
    }
}

#[test]
fn four_joints_fit_on_one_screen() {
    let folder = Folder::new();
    legs(&folder, "three.toml", None, &[]);
    let three = std::fs::read_to_string(folder.0.path().join("three.toml")).unwrap();
    let knee = &three[three.find("[[joint]]\nname = \"knee\"").unwrap()..];
    folder.write("four.toml", &format!("{three}\n{}", knee.replace("\"knee\"", "\"ankle\"")));
    for (width, most) in [(80, 32), (120, 30)] {
        let text = folder.run(&["optimize", "four.toml", "--catalog", "catalog"], Some(width));
        assert!(text.lines().count() <= most, "{} lines at {width}:\n{text}", text.lines().count());
        // It is the short one.
        let full = folder.run(&["optimize", "four.toml", "--catalog", "catalog", "--full"], Some(width));
        assert!(full.lines().count() > 2 * text.lines().count(), "{full}");
    }
}

#[test]
fn why_says_what_the_json_says() {
    let folder = Folder::new();
    legs(&folder, "legs.toml", None, &[]);
    legs(&folder, "narrow.toml", Some("\"loss\""), &[("max = 20", "max = 4")]);
    folder.requirement("humanoid_hip_catalog_gears.toml", "gears.toml", &[]);
    let (mut bounds, mut flats, mut fronts, mut nears) = (0, 0, 0, 0);
    for file in ["legs.toml", "narrow.toml", "gears.toml"] {
        let words = ["optimize", file, "--catalog", "catalog", "--why"];
        let json = folder.json(&words);
        let text = collapsed(&folder.run(&words, Some(120)));
        let mut rest = text.as_str();
        for joint in all(&json["joints"]) {
            // Nothing is explained where nothing was chosen.
            if all(&joint["candidates"]).is_empty() {
                continue;
            }
            let first = &joint["candidates"][0];
            let why = format!(" Why {} at N = {}: ", first["motor"].as_str().unwrap(), ratio_of(first));
            rest = &rest[rest.find(&why).unwrap_or_else(|| panic!("{why} in\n{text}"))..];
            let next = rest[1..].find(" Why ").map_or(rest.len(), |at| at + 1);
            let own = &rest[..next];
            let at = |value: &Value| value.as_f64().unwrap();
            match joint.get("flatness") {
                Some(flat) => {
                    let (from, to, n) = (at(&flat["from"]), at(&flat["to"]), at(&first["ratio"]));
                    assert!(from <= n && n <= to && at(&flat["within"]) == 0.03, "{flat}");
                    let said = format!(
                        "within 3 % of its least from N = {} to {}",
                        number_between(from, from, to),
                        number_between(to, from, to)
                    );
                    assert!(own.contains(&said), "{said} in\n{own}");
                    flats += 1;
                }
                None => assert!(!own.contains("within 3 %") && first["gear"].is_string(), "{own}"),
            }
            assert_eq!(own.contains("your own bound on the ratio decides"), joint["own_bound"].is_object(), "{own}");
            bounds += usize::from(joint["own_bound"].is_object());
            if let Some(near) = joint.get("near_gears") {
                for gear in all(&near["gears"]) {
                    let named = format!(" {}:1 {}: ", shown(&gear["ratio"]), gear["gear"].as_str().unwrap());
                    let rest = &own[own.find(&named).unwrap_or_else(|| panic!("{named} in\n{own}")) + named.len()..];
                    let line = &rest[..rest.find(":1 ").unwrap_or(rest.len())];
                    assert_eq!(line.contains("all limits kept"), gear["keeps_all"] == true, "{line}");
                    let standing = gear["standing"].as_str().unwrap();
                    assert_eq!(line.contains("exceeds "), standing == "exceeds", "{line}");
                    assert_eq!(line.contains("cannot be judged"), standing == "unjudged", "{line}");
                    let parts = &gear["parts"];
                    if parts["inertia"].is_number() {
                        let of = |key: &str| parts[key].as_f64().unwrap_or(0.0);
                        let sum = of("ratio") + of("efficiency") + of("inertia") + of("mass");
                        assert!((sum - at(&gear["more"])).abs() <= 1e-9 * at(&gear["objective"]).abs(), "{gear}");
                    }
                    nears += 1;
                }
                assert_eq!(own.contains("no gear of the catalogue"), near["gap"].is_object(), "{own}");
            }
            assert_eq!(own.contains("simple planetary near by"), joint["near_planetary"].is_object(), "{own}");
            if let Some(front) = joint.get("front") {
                // From the lightest to the least loss: each is heavier and loses less than the one before.
                for pair in all(front).windows(2) {
                    assert!(at(&pair[0]["mass_kg"]) <= at(&pair[1]["mass_kg"]) * (1.0 + 1e-9), "{front}");
                    assert!(at(&pair[0]["loss_w"]) >= at(&pair[1]["loss_w"]) * (1.0 - 1e-6), "{front}");
                }
                let end = |k: usize| (front[k]["motor"].clone(), front[k]["mass_kg"].clone());
                let (last, choices) = (all(front).len() - 1, &joint["choices"]);
                assert_eq!(end(0), (choices["lightest"]["motor"].clone(), choices["lightest"]["mass_kg"].clone()));
                assert_eq!(end(last).0, choices["least_loss"]["motor"]);
                fronts += 1;
            }
        }
        assert_nothing_folded(folder.0.path(), &words);
    }
    assert!(bounds > 0 && flats > bounds && fronts == 3 && nears > 0, "{bounds} {flats} {fronts} {nears}");
}

/// Exit status and what is printed, both streams together.
fn run(folder: &Folder, words: &[&str]) -> (i32, String) {
    let output =
        Command::new(env!("CARGO_BIN_EXE_gearwise")).args(words).current_dir(folder.0.path()).output().unwrap();
    let said = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap()).concat();
    (output.status.code().unwrap(), said)
}

#[test]
fn a_printed_ratio_can_be_typed_back() {
    let folder = Folder::new();
    // The ratio stands at a limit of the inertia.
    folder.requirement("quadruped_mini_cheetah.toml", "legs.toml", &[("actuator_mass = \"0.55 kg\"\n", "")]);
    let json = folder.json(&["optimize", "legs.toml", "--catalog", "catalog"]);
    let mut at_a_limit = 0;
    for joint in all(&json["joints"]) {
        for design in all(&joint["candidates"]) {
            let typed = format!("{}@{}", design["motor"].as_str().unwrap(), ratio_of(design));
            let joint = joint["joint"].as_str().unwrap();
            let (status, said) =
                run(&folder, &["explain", &typed, "legs.toml", "--joint", joint, "--catalog", "catalog"]);
            assert_eq!(status, 0, "{typed}:\n{said}");
            at_a_limit += usize::from(ratio_of(design) != shown(&design["ratio"]));
        }
    }
    assert!(at_a_limit > 0, "no ratio had to be rounded inwards");
}

#[test]
fn listed_ratios_are_kept_by_every_command() {
    let folder = Folder::new();
    for (name, ratio, allowed) in [
        ("list.toml", "ratio = { values = [5, 6.5, 8] }", [5.0, 6.5, 8.0]),
        ("grid.toml", "ratio = { min = 5, max = 8.2, step = 1.5 }", [5.0, 6.5, 8.0]),
    ] {
        legs(&folder, name, Some("\"loss\""), &[("ratio = { min = 3, max = 20 }", ratio)]);
        let catalog = ["--catalog", "catalog"];
        let json = |words: &[&str]| folder.json(&[words, &catalog[..]].concat());
        let is_allowed = |ratio: &Value| allowed.contains(&ratio.as_f64().unwrap());
        let best = json(&["optimize", name]);
        for joint in all(&best["joints"]) {
            assert!(!all(&joint["candidates"]).is_empty() && joint.get("flatness").is_none());
            for design in all(&joint["candidates"]) {
                assert!(is_allowed(&design["ratio"]), "{}", design["ratio"]);
                let certificate = &design["certificate"];
                assert!(certificate["certified"] == true && certificate["method"] == "all listed ratios evaluated");
            }
        }
        for joint in all(&json(&["sweep", name, "--ratios", "7"])["joints"]) {
            let ratios: Vec<f64> = all(&joint["candidates"]).iter().map(|d| d["ratio"].as_f64().unwrap()).collect();
            assert!(!ratios.is_empty() && ratios.iter().all(|n| allowed.contains(n)), "{ratios:?}");
        }
        for joint in all(&json(&["optimize", name, "--pareto", "loss,reflected_inertia"])["joints"]) {
            assert!(!all(&joint["candidates"]).is_empty());
            assert!(all(&joint["candidates"]).iter().all(|d| is_allowed(&d["ratio"])), "{joint}");
        }
        for joint in all(&json(&["optimize", name, "--robust"])["joints"]) {
            assert!(all(&joint["candidates"]).iter().all(|d| is_allowed(&d["ratio"])), "{joint}");
        }
        let whole = json(&["optimize", name, "--robot"]);
        assert!(all(&whole["robot"]["choice"]["best"]["joints"]).iter().all(|d| is_allowed(&d["ratio"])));
        let text = folder.run(&[&["optimize", name, "--full"], &catalog[..]].concat(), None);
        let said = if name == "list.toml" { "ratio 5, 6.5, 8," } else { "ratio 5 to 8 in steps of 1.5," };
        assert!(text.contains(said), "{text}");
        // Of one design: what is listed may be explained and checked, what is not is refused.
        let first = &best["joints"][0]["candidates"][0];
        let (motor, ratio) = (first["motor"].as_str().unwrap(), number(first["ratio"].as_f64().unwrap()));
        let explain = |ratio: &str| {
            let design = format!("{motor}@{ratio}");
            run(&folder, &[&["explain", &design, name, "--joint", "hip_abad"], &catalog[..]].concat())
        };
        assert_eq!(explain(&ratio).0, 0);
        let (status, said) = explain("5.5");
        assert!(status == 1 && collapsed(&said).contains("a ratio that the requirement does not list"), "{said}");
        let (status, said) =
            run(&folder, &[&["optimize", name, "--no-rules", "--write-design", "design.toml"], &catalog[..]].concat());
        assert_eq!(status, 0, "{said}");
        let design = std::fs::read_to_string(folder.0.path().join("design.toml")).unwrap();
        assert_ne!(run(&folder, &["check", "design.toml"]).0, 2, "{design}");
        let line = design.lines().find(|l| l.starts_with("ratio = ")).unwrap();
        std::fs::write(folder.0.path().join("other.toml"), design.replacen(line, "ratio = 5.5", 1)).unwrap();
        let (status, said) = run(&folder, &["check", "other.toml"]);
        assert!(status == 2 && collapsed(&said).contains("none of those that the requirement lists"), "{said}");
        assert!(collapsed(&said).contains("the nearest: 5, 6.5"), "{said}");
    }
}
