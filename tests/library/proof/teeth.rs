//! Ratios of planetary stages by their teeth: against an enumeration that goes another way, against published gears, and what
//! the choice makes of them.

use std::collections::HashMap;
use std::sync::Arc;

use gearwise::catalog::Catalog;
use gearwise::design::optimize;
use gearwise::input::Source;
use gearwise::requirement::{NoTeeth, Robot, Stage, read_source, trains};

/// Planets are put in one after the other at equal angles: the k-th meshes with the sun and with the ring where its teeth meet the gaps of both.
/// Turned by θ, the sun stands at S θ and the ring at R θ in teeth; a planet with Z teeth that turns from the first place to
/// this one must have moved by a whole number of teeth against both.
fn meshes(stage: Stage, planets: u32) -> bool {
    let (s, r) = (f64::from(stage.sun), f64::from(stage.ring));
    let z = (r - s) / 2.0;
    if z < 8.0 || z.fract() != 0.0 {
        return false;
    }
    let whole = |x: f64| (x - x.round()).abs() < 1e-9;
    // Of a planet at the angle a its own turn follows from the ring, in teeth: R a. Against the sun it then has S a + R a.
    let all = (1..planets).all(|k| whole((s + r) * f64::from(k) / f64::from(planets)));
    // Centres of neighbours at a distance of the carrier's chord, in modules: (S + Z)/2 from the axis each.
    let angle = 2.0 * std::f64::consts::PI / f64::from(planets);
    let (radius, here) = ((s + z) / 2.0, [0.0, angle]);
    let [a, b] = here.map(|angle| [radius * angle.cos(), radius * angle.sin()]);
    let chord = ((a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)).sqrt();
    all && chord > z + 2.0 + 1e-12
}

/// All trains by plain loops over every tooth, and of each ratio (as a decimal of twelve digits) how many and the fewest teeth.
fn by_loops(stages: &[[f64; 2]], sun: [u32; 2], ring_max: u32, planets: u32) -> HashMap<String, (u64, u32)> {
    let mut all: Vec<(f64, u32)> = vec![(1.0, 0)];
    for [min, max] in stages {
        let mut next = Vec::new();
        for (ratio, teeth) in &all {
            for s in sun[0]..=sun[1] {
                for r in 1..=ring_max {
                    let stage = Stage { sun: s, ring: r };
                    let own = 1.0 + f64::from(r) / f64::from(s);
                    if own >= min - 1e-9 && own <= max + 1e-9 && r > s && meshes(stage, planets) {
                        next.push((ratio * own, teeth + s + r));
                    }
                }
            }
        }
        all = next;
    }
    let mut found: HashMap<String, (u64, u32)> = HashMap::new();
    for (ratio, teeth) in all {
        let (count, fewest) = found.entry(format!("{ratio:.11e}")).or_insert((0, u32::MAX));
        *count += 1;
        *fewest = (*fewest).min(teeth);
    }
    found
}

#[test]
fn every_train_that_can_be_assembled_is_there_and_no_other() {
    let mut seen = [0; 3];
    for (stages, sun, ring_max, planets) in [
        (vec![[2.5, 10.0]], [18, 40], 120, 3),
        (vec![[3.0, 10.0]], [12, 30], 150, 4),
        (vec![[3.0, 6.0]], [17, 45], 140, 5),
        (vec![[3.0, 4.0], [4.0, 8.0]], [18, 22], 90, 3),
        (vec![[3.0, 5.0], [3.0, 5.0]], [20, 26], 100, 3),
        (vec![[3.0, 4.0], [3.0, 4.0], [3.0, 4.0]], [20, 24], 80, 3),
        (vec![[4.0, 4.0]], [24, 24], 72, 3),
    ] {
        let found = trains(&stages, sun, ring_max, planets).unwrap();
        let paper = by_loops(&stages, sun, ring_max, planets);
        assert_eq!(found.ratios, paper.len(), "{stages:?}");
        assert_eq!(found.within.is_some(), found.ratios > 1000);
        for gear in &found.gears {
            let (count, fewest) = paper[&format!("{:.11e}", gear.ratio)];
            assert_eq!((gear.others + 1, gear.train.teeth()), (count, fewest), "{gear:?}");
            assert!((gear.train.ratio() / gear.ratio - 1.0).abs() < 1e-14);
            assert_eq!(gear.train.stages.len(), stages.len());
            for (stage, [min, max]) in gear.train.stages.iter().zip(&stages) {
                assert!(meshes(*stage, planets) && *min - 1e-9 <= stage.ratio() && stage.ratio() <= *max + 1e-9);
            }
            seen[usize::from(gear.others > 0)] += 1;
        }
        assert!(found.gears.windows(2).all(|pair| pair[0].ratio < pair[1].ratio));
        seen[2] += 1;
    }
    assert!(seen[0] > 50 && seen[1] > 50, "{seen:?}");
}

/// Sets of teeth that others publish can be assembled, have the published ratio, and are found.
#[test]
fn published_gears_are_among_them() {
    // COMPAct (arXiv 2510.07197), results of the repository at 4a0531b: sun, planet, ring, planets, ratio.
    for (sun, planet, ring, planets, ratio) in [
        (31, 38, 107, 3, 4.451612903225806),
        (33, 45, 123, 3, 4.7272727272727275),
        (31, 47, 125, 3, 5.032258064516129),
        (24, 42, 108, 3, 5.5),
        (19, 38, 95, 3, 6.0),
        (23, 52, 127, 3, 6.521739130434782),
        (18, 45, 108, 3, 7.0),
        (49, 51, 151, 4, 4.081632653061225),
        (31, 31, 93, 4, 4.0),
        (52, 28, 108, 4, 3.076923076923077),
        (28, 29, 86, 3, 4.071428571428571),
    ] {
        let stage = Stage { sun, ring };
        assert!(stage.can_be_assembled(planets) && stage.planet() == planet, "{stage:?}");
        assert!((stage.ratio() - ratio).abs() < 1e-12);
        let found = trains(&[[3.0, 8.0]], [sun, sun], ring, planets).unwrap();
        assert!(found.of(ratio).is_some());
        assert!(found.gears.iter().any(|gear| gear.train.stages == [stage]));
    }
    // Two stages there: 50/28/106 with 3 planets and 46/28/102 with 4, together 10.038.
    let ratio = Stage { sun: 50, ring: 106 }.ratio() * Stage { sun: 46, ring: 102 }.ratio();
    assert!((ratio - 10.038260869565217).abs() < 1e-12);
    // The 7.2:1 gear that they made and tested is 25/65/155, and it is not one for 7 planets.
    assert!(Stage { sun: 25, ring: 155 }.can_be_assembled(3) && !Stage { sun: 25, ring: 155 }.can_be_assembled(7));
}

/// Too many ratios: what is left out is near one that is listed, which has no more teeth; and that is said.
#[test]
fn what_is_left_out_of_a_long_list_is_near_one_that_is_not() {
    let (stages, sun, ring_max) = ([[3.0, 10.0], [3.0, 10.0]], [18, 30], 120);
    let found = trains(&stages, sun, ring_max, 3).unwrap();
    let paper = by_loops(&stages, sun, ring_max, 3);
    let within = found.within.unwrap();
    assert_eq!(found.ratios, paper.len());
    assert!(found.gears.len() <= 1000 && found.gears.len() > 500 && found.ratios > 3000 && within < 0.005);
    for (ratio, (_, fewest)) in &paper {
        let ratio: f64 = ratio.parse().unwrap();
        let near = |n: f64| n / ratio <= 1.0 + within && ratio / n <= 1.0 + within;
        assert!(found.gears.iter().any(|g| near(g.ratio) && g.train.teeth() <= *fewest), "{ratio}");
    }
    // More than are looked at is refused, and a stage that nothing makes names the next ones.
    let many = trains(&[[3.0, 10.0]; 3], [18, 60], 200, 3);
    assert!(matches!(many, Err(NoTeeth::Many(products)) if products > 2_000_000), "{many:?}");
    let none = trains(&[[3.0, 4.0], [4.01, 4.02]], [24, 24], 120, 3);
    let Err(NoTeeth::Stage(1, [Some(below), Some(above)])) = none else { panic!("{none:?}") };
    assert!(below.ratio() < 4.01 && above.ratio() > 4.02);
    let between = |ring| Stage { sun: 24, ring }.can_be_assembled(3);
    assert!((below.ring + 1..above.ring).all(|ring| !between(ring)));
    assert_eq!(trains(&[[4.0, 5.0]], [18, 20], 30, 3), Err(NoTeeth::Stage(0, [None, None])));
}

const JOINT: &str = r#"
name = "one"
[bus]
voltage = "24 V"
drive_current = "40 A"
[[joint]]
name = "knee"
objective = "loss"
RATIO
gear = { efficiency = 0.9 GEAR }
points = [{ torque = "12 N*m", speed = "4 rad/s", acceleration = "20 rad/s^2", duration = "1 s" },
  { torque = "-3 N*m", speed = "-6 rad/s", acceleration = "-30 rad/s^2", duration = "1 s" }]
"#;

fn robot(ratio: &str, gear: &str) -> Robot {
    let text = JOINT.replace("RATIO", ratio).replace("GEAR", gear);
    read_source(&Arc::new(Source::new("robot.toml", text))).unwrap()
}

/// The choice is that of the same ratios as a list; the mass counts the listed stages.
#[test]
fn the_choice_is_that_of_the_ratios_as_a_list() {
    let catalog = Catalog::builtin().unwrap();
    let teeth = "ratio = { stages = [[3, 5], [3, 5]], teeth = { sun = [20, 24], ring_max = 90 } }";
    let by_teeth = robot(teeth, ", mass_per_stage = \"150 g\"");
    let list = by_teeth.joints[0].ratio.listed().unwrap().to_vec();
    let values: Vec<String> = list.iter().map(|n| format!("{n:?}")).collect();
    let listed = robot(&format!("ratio = {{ values = [{}] }}", values.join(", ")), ", mass = \"300 g\"");
    // Two stages at every ratio, as listed.
    assert_eq!(by_teeth.joints[0].gear, listed.joints[0].gear);
    assert_eq!(by_teeth.joints[0].gear.mass_at(list[0]), Some(0.3));
    let one = robot(
        "ratio = { stages = [[3, 9]], teeth = { sun = [20, 24], ring_max = 90 } }",
        ", mass_per_stage = \"150 g\"",
    );
    assert_eq!(one.joints[0].gear.mass_at(8.0), Some(0.15));
    let (a, b) = (optimize(&by_teeth, &catalog), optimize(&listed, &catalog));
    let (a, b) = (&a.joints[0].candidates, &b.joints[0].candidates);
    assert!(a.len() == b.len() && a.len() > 5, "{}", a.len());
    for (a, b) in a.iter().zip(b) {
        assert_eq!((&a.motor.id, a.optimum.ratio.to_bits()), (&b.motor.id, b.optimum.ratio.to_bits()));
        let gear = by_teeth.joints[0].ratio.toothed(a.optimum.ratio).unwrap();
        assert!((gear.train.ratio() / a.optimum.ratio - 1.0).abs() < 1e-12);
    }
    assert!(listed.joints[0].ratio.toothed(list[0]).is_none());
}

/// Every mistake has its place and says what to do.
#[test]
fn mistakes_of_teeth_have_their_place() {
    let teeth = "teeth = { sun = [18, 40], ring_max = 120 }";
    let cases: &[(&str, &str, &str)] = &[
        ("stages = [[3, 10]], min = 3, teeth = { sun = [18, 40], ring_max = 120 }", "they have no `min`", "min"),
        (
            "stages = [[3, 10]], values = [3], teeth = { sun = [18, 40], ring_max = 120 }",
            "they have no `values`",
            "values",
        ),
        ("stages = [[3, 10]]", "`teeth` of [ratio] is missing", "{ stages"),
        (teeth, "`stages` of [ratio] is missing", "{ teeth"),
        ("stages = [[10, 3]], teeth = { sun = [18, 40], ring_max = 120 }", "upside down: 10 to 3", "stages"),
        ("stages = [], teeth = { sun = [18, 40], ring_max = 120 }", "`stages` lists 0 stages", "stages"),
        ("stages = [[3, 4], [3, 4], [3, 4], [3, 4]], teeth = { sun = [18, 20], ring_max = 90 }", "4 stages", "stages"),
        ("stages = [[3, 10]], teeth = { sun = [40, 18], ring_max = 120 }", "upside down: 40 to 18", "sun"),
        ("stages = [[3, 10]], teeth = { sun = [5, 18], ring_max = 120 }", "a sun of 5 teeth", "sun"),
        ("stages = [[3, 10]], teeth = { sun = [18.5, 40], ring_max = 120 }", "not a pair [fewest, most]", "sun"),
        ("stages = [[3, 10]], teeth = { sun = [18], ring_max = 120 }", "not a pair [fewest, most]", "sun"),
        ("stages = [[3, 10]], teeth = { sun = [18, 40], ring_max = 30 }", "has no room for a sun of 18", "ring_max"),
        ("stages = [[3, 10]], teeth = { sun = [18, 40], ring_max = 900 }", "up to 900 teeth", "ring_max"),
        (
            "stages = [[3, 10]], teeth = { sun = [18, 40], ring_max = 120, planets = 1 }",
            "a stage of 1 planets",
            "planets",
        ),
        ("stages = [[3, 10]], teeth = { sun = [18, 40] }", "`ring_max` of [teeth] is missing", "{ sun"),
        (
            "stages = [[3.01, 3.02]], teeth = { sun = [18, 20], ring_max = 120 }",
            "no planetary stage of these teeth",
            "stages",
        ),
        (
            "stages = [[3, 10], [3, 10], [3, 10]], teeth = { sun = [18, 60], ring_max = 200 }",
            "products of ratios",
            "stages",
        ),
    ];
    for (ratio, message, place) in cases {
        let text = JOINT.replace("RATIO", &format!("ratio = {{ {ratio} }}")).replace("GEAR", "");
        let errors = read_source(&Arc::new(Source::new("robot.toml", text.clone()))).unwrap_err();
        let problems: Vec<_> = errors.iter().flat_map(|error| &error.problems).collect();
        let problem = problems.iter().find(|p| p.message.contains(message));
        let problem = problem.unwrap_or_else(|| panic!("{ratio}: {message} in {problems:?}"));
        let start = problem.span.clone().unwrap().start;
        // The value of the key, or the table that lacks it.
        let (before, at) = text.split_at(start);
        let is_there = at.starts_with(place) || before.ends_with(&format!("{place} = "));
        assert!(is_there, "{ratio}: at {}", &at[..20.min(at.len())]);
        assert_eq!(problems.len(), 1, "{ratio}: {problems:?}");
    }
    // A number of stages that is said twice.
    let gear = ", mass_per_stage = \"150 g\", stage_ratio = 5";
    let ratio = format!("ratio = {{ stages = [[3, 10]], {teeth} }}");
    let text = JOINT.replace("RATIO", &ratio).replace("GEAR", gear);
    let errors = read_source(&Arc::new(Source::new("robot.toml", text))).unwrap_err();
    assert!(errors[0].problems[0].message.contains("`ratio` lists the stages itself"), "{errors:?}");
}

/// A ratio of teeth that was read in four digits is the ratio of the teeth; of other lists a ratio stays what it is.
#[test]
fn a_printed_ratio_of_teeth_is_found_again() {
    let by_teeth = robot("ratio = { stages = [[3, 5], [3, 5]], teeth = { sun = [20, 24], ring_max = 90 } }", "");
    let ratio = &by_teeth.joints[0].ratio;
    let list = ratio.listed().unwrap();
    for n in list {
        let printed: f64 = gearwise::report::number(*n).parse().unwrap();
        let found = ratio.as_printed(printed);
        // Of several ratios that are printed alike it is the nearest.
        let away = |n: f64| (n / printed - 1.0).abs();
        assert!(ratio.allows(found) && away(found) <= away(*n), "{n} {printed} {found}");
        assert_eq!(ratio.as_printed(*n), *n);
    }
    assert_eq!(ratio.as_printed(0.5), 0.5);
    let plain = robot("ratio = { values = [5, 6] }", "");
    assert_eq!(plain.joints[0].ratio.as_printed(5.0001), 5.0001);
}
