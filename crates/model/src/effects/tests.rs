use super::features::{Feature, sign};
use super::*;
use std::collections::HashSet;

const SCALE: Scale =
    Scale { torque_constant: 0.1, resistance: 0.5, torque: 2.0, speed: 200.0, current: 20.0, voltage: 48.0 };

fn point() -> Operating {
    Operating {
        speed: 30.0,
        direction: 1.0,
        angle: 0.7,
        output_angle: 0.1,
        current: 7.0,
        torque: 0.6,
        torque_curvature: 3.0,
        winding_rise: 40.0,
        housing_rise: 20.0,
        duty: 0.4,
    }
}

#[test]
fn the_list_is_sound() {
    let mut names = HashSet::new();
    for effect in EFFECTS {
        assert!(names.insert(effect.name()), "{} stands twice", effect.name());
        assert!(!effect.equation().is_empty() && !effect.parameters().is_empty() && !effect.needs().is_empty());
        assert!((1..=2).contains(&effect.linear()), "{}", effect.name());
        assert!(effect.basis(12.0, &point()).iter().all(|b| b.is_finite()), "{}", effect.name());
    }
}

#[test]
fn friction_dissipates_and_a_negative_one_is_not_believed() {
    let friction =
        ["viscous_friction", "coulomb_friction", "eddy_drag", "stribeck_friction", "load_dependent_friction"];
    for name in friction {
        let effect = effect(name).unwrap();
        for (speed, torque) in [(30.0, 0.6), (-30.0, 0.6), (30.0, -0.6), (-5.0, -0.6)] {
            let at = Operating { speed, direction: sign(speed), torque, ..point() };
            assert!(effect.basis(25.0, &at)[0] * speed > 0.0, "{name} makes energy");
        }
        assert!(effect.plausible(&[-0.01, 25.0], &SCALE).is_err(), "{name}");
    }
}

#[test]
fn effects_of_the_shaft_form_agree_with_their_basis() {
    for effect in EFFECTS {
        let values = vec![0.03; effect.parameters().len()];
        let Enters::Features(form) = effect.enters(&values) else { continue };
        for speed in [-30.0, 12.0] {
            let at = Operating { speed, direction: sign(speed), ..point() };
            let features: f64 = form[Feature::Velocity] * speed
                + form[Feature::Sign] * sign(speed)
                + form[Feature::Speed] * speed.abs()
                + form[Feature::One];
            approx::assert_relative_eq!(features, effect.value(&values, &at), max_relative = 1e-12);
        }
    }
}

/// Words that are the name of an effect and something else too, with the places where they are that: columns of a row,
/// a limit, a channel of a log, a key of a file.
const OTHER_MEANINGS: [(&str, &[&str]); 6] = [
    // The key of a simulator, and a row of a table.
    ("cogging", &["select/simulated/facts.rs", "report/export/"]),
    (
        "viscous_friction",
        &[
            "catalog/",
            "select/robust/",
            "identify/bench.rs",
            "identify/characterize/drag.rs",
            "identify/fitted.rs",
            "identify/read/",
            "pages/formats.rs",
            "report/export/isaaclab.rs",
            "report/fitted.rs",
            "rules/hardware/joint.rs",
        ],
    ),
    (
        "coulomb_friction",
        &[
            "catalog/",
            "select/robust/",
            "identify/bench.rs",
            "identify/characterize/drag.rs",
            "identify/fitted.rs",
            "identify/read/",
            "pages/formats.rs",
            "report/fitted.rs",
        ],
    ),
    (
        "winding_temperature",
        &[
            "actuator/limits",
            "select/figures.rs",
            "select/robust/",
            "identify/read/",
            "pages/formats.rs",
            "report/",
            "requirement/",
            "rules/",
        ],
    ),
    ("gravity", &["mechanism/", "requirement/", "pages/formats.rs"]),
    (
        "backlash",
        &[
            "catalog/gear.rs",
            "select/families.rs",
            "select/simulated/facts.rs",
            "pages/formats.rs",
            "report/catalog/card.rs",
            "requirement/gear.rs",
            "transmission/read.rs",
        ],
    ),
];

/// Every place of a source file's code, without its tests, where a text is the name of an effect.
fn names_in(text: &str) -> Vec<&'static str> {
    let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or(text);
    let code: String = code.lines().filter(|l| !l.trim_start().starts_with("//")).collect();
    EFFECTS.iter().map(|e| e.name()).filter(|name| code.contains(&format!("\"{name}\""))).collect()
}

fn sources(folder: &std::path::Path, found: &mut Vec<std::path::PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") && path.file_name().is_some_and(|n| n != "tests.rs") {
            found.push(path);
        }
    }
}

/// What an effect does is data in its own file: no other part of the program asks for its name.
#[test]
fn no_name_of_an_effect_is_matched_outside_its_own_file() {
    let src = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let root = src.join("../../..");
    let mut files = Vec::new();
    let mut read = 0;
    for (folder, prefix) in [
        ("src", ""),
        ("crates/model/src", ""),
        ("crates/select/src", "select/"),
        ("crates/identify/src", "identify/"),
        ("crates/rules/src", "rules/"),
        ("crates/report/src", "report/"),
    ] {
        let (folder, mut found) = (root.join(folder), Vec::new());
        sources(&folder, &mut found);
        read += found.len();
        let place = |file: &std::path::PathBuf| format!("{prefix}{}", file.strip_prefix(&folder).unwrap().display());
        files.extend(found.iter().map(|file| (place(file), file.clone())));
    }
    assert!(read > 400, "{read} files");
    let mut wrong = Vec::new();
    for (place, file) in files {
        for name in names_in(&std::fs::read_to_string(&file).unwrap()) {
            let own = place.starts_with("effects/") && place != "effects/mod.rs";
            let meanings = OTHER_MEANINGS.iter().filter(|(word, _)| *word == name).flat_map(|(_, places)| *places);
            if !own && !meanings.into_iter().any(|p| place.starts_with(p)) {
                wrong.push(format!("{place} has \"{name}\""));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    // It can fail.
    assert_eq!(names_in("match name {\n    \"cogging\" => 1,\n}\n// \"gravity\"\n"), ["cogging"]);
    // In the room itself each name is said once.
    for effect in EFFECTS {
        let mut files = Vec::new();
        sources(&src.join("effects"), &mut files);
        let texts = files.iter().map(|f| std::fs::read_to_string(f).unwrap());
        let names = texts.filter(|t| t.contains("fn name(") && names_in(t).contains(&effect.name())).count();
        assert_eq!(names, 1, "{}", effect.name());
    }
}

/// Effects that a position shows are tried in one order.
#[test]
fn places_among_what_a_position_shows_are_taken_once() {
    let mut ranks: Vec<u32> = EFFECTS.iter().filter_map(|e| e.rank_in_position()).collect();
    let all = ranks.len();
    ranks.sort_unstable();
    ranks.dedup();
    assert_eq!(ranks.len(), all);
}
