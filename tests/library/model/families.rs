//! Families of gears: each point is the gear of a catalogue with its numbers, ratios between points say that they are, and
//! what a family does not say is not said to be kept.

use std::sync::Arc;

use gearwise::catalog::row::csv_text;
use gearwise::catalog::{Catalog, Gear};
use gearwise::design::families::settled;
use gearwise::design::{Evaluation, optimize, sweep};
use gearwise::input::Source;
use gearwise::requirement::{self, FamilyPlace, RatioChoice, Robot};

const ROBOT: &str = r#"
name = "leg"
ambient = { temperature = "25 degC" }
[bus]
voltage = "24 V"
[[joint]]
name = "knee"
motors = ["t-motor-u8*"]
family = ["compact-u8-*"]
objective = "loss"
points = [
    { torque = "8 N*m", speed = "5 rad/s", duration = "0.4 s" },
    { torque = "2 N*m", speed = "-12 rad/s", duration = "0.3 s" },
    { torque = "0.5 N*m", speed = "8 rad/s", duration = "0.3 s" },
]
[joint.limits]
winding_temperature = "110 degC"
"#;

fn robot(changes: &[(&str, &str)]) -> Robot {
    let mut text = ROBOT.to_string();
    for (from, to) in changes {
        assert!(text.contains(from), "`{from}`");
        text = text.replacen(from, to, 1);
    }
    requirement::read_source(&Source::new("robot.toml", text).into()).unwrap_or_else(|e| panic!("{}", e[0]))
}

fn catalog() -> Catalog {
    Catalog::builtin().unwrap().free(false)
}

/// The built-in catalogue with the points of its families as gears in their place.
fn as_gears() -> Catalog {
    let builtin = Catalog::builtin().unwrap();
    let points: Vec<Gear> = builtin.families.iter().flat_map(|family| family.points.clone()).collect();
    let gears = Source::new("gears.csv", csv_text(&points, &[]));
    let sources = Catalog::builtin_sources().into_iter().filter(|source| source.name().contains("/motors/"));
    Catalog::from_sources(sources.chain([Arc::new(gears)]).collect()).unwrap_or_else(|e| panic!("{}", e[0])).free(false)
}

#[test]
fn each_point_is_the_gear_of_a_catalogue_to_the_last_bit() {
    let (own, plain) = (catalog(), as_gears());
    let of_family = settled(robot(&[]), &own).unwrap();
    let of_gears = settled(robot(&[("family =", "gears =")]), &plain).unwrap();
    let (mut family, mut gears) = (sweep(&of_family, &own, 0), sweep(&of_gears, &plain, 0));
    for swept in [&mut family, &mut gears] {
        swept[0].designs.sort_by_key(|design| design.gear);
    }
    assert_eq!(family[0].designs.len(), 22);
    assert_eq!(gears[0].designs.len(), 22);
    for (a, b) in family[0].designs.iter().zip(&gears[0].designs) {
        assert_eq!((a.motor.id.as_str(), a.gear), (b.motor.id.as_str(), b.gear));
        let bits = |x: &Evaluation| [x.loss, x.mass.unwrap(), x.ratio, x.reflected_inertia].map(f64::to_bits);
        assert_eq!(bits(&a.evaluation), bits(&b.evaluation), "{:?}", a.gear);
        let margins = |x: &Evaluation| -> Vec<_> {
            x.margins.iter().map(|m| (m.limit, m.demand.to_bits(), m.bound.to_bits())).collect()
        };
        assert_eq!(margins(&a.evaluation), margins(&b.evaluation));
        assert_eq!(a.unchecked, b.unchecked);
    }
    let (best, other) = (optimize(&of_family, &own), optimize(&of_gears, &plain));
    assert_eq!(best.joints[0].candidates[0].gear, other.joints[0].candidates[0].gear);
}

/// Numbers of the published table: the actuator weighs what it says, and its peak torque is the motor's times N.
#[test]
fn the_actuator_weighs_what_was_published() {
    let own = catalog();
    let of_family = settled(robot(&[]), &own).unwrap();
    let swept = sweep(&of_family, &own, 0);
    for (gear, mass, length) in [
        ("compact-u8-sspg-6", 0.540, 0.0625),
        ("compact-u8-sspg-7", 0.587, 0.064_83),
        ("compact-u8-cpg-15.59", 0.796, 0.096_15),
        ("compact-u8-dspg-10.04", 0.827, f64::NAN),
    ] {
        let design = swept[0].designs.iter().find(|d| d.gear == Some(gear)).unwrap();
        assert!((design.evaluation.mass.unwrap() - mass).abs() < 1e-9, "{gear} {:?}", design.evaluation.mass);
        let point = own.gear(gear).unwrap();
        assert!(length.is_nan() || (point.length.unwrap() + 0.0265 - length).abs() < 1e-9, "{gear}");
        assert!((point.peak_torque.unwrap() / (2.291_831 * point.ratio) - 1.0).abs() < 1e-4, "{gear}");
    }
}

/// A gear that cannot be bought is none of the gears that can, whatever the pattern.
#[test]
fn points_are_not_among_gears_that_can_be_bought() {
    let own = catalog();
    let free = settled(robot(&[("family = [\"compact-u8-*\"]", "gears = [\"*\"]")]), &own).unwrap();
    let swept = sweep(&free, &own, 0);
    assert!(swept[0].designs.iter().all(|d| d.gear.is_some_and(|id| own.gears.iter().any(|g| g.id == id))));
    assert!(robot(&[("family =", "gears =")]).joints[0].ratio.is_catalog());
    let why = settled(robot(&[("family =", "gears =")]), &own).unwrap_err();
    assert!(why.contains("no gear of the catalogue matches `compact-u8-*`"), "{why}");
}

/// Between points: the answer is there or at a point as the limits have it, and what it is said to be is what it is.
#[test]
fn a_ratio_between_points_is_said_to_be_none_that_was_published() {
    let own = catalog();
    let between = |limit: &str| {
        let family = "family = [\"compact-u8-cpg\"]\nbetween = true";
        let limits = format!("winding_temperature = \"110 degC\"\n{limit}");
        let changes =
            [("family = [\"compact-u8-*\"]", family), ("winding_temperature = \"110 degC\"", limits.as_str())];
        settled(robot(&changes), &own).unwrap()
    };
    for (limit, ratio, ids) in [
        ("", 15.589_285_714_3, &["compact-u8-cpg-15.59"][..]),
        ("actuator_mass = \"710 g\"", 0.0, &["compact-u8-cpg-11.41", "compact-u8-cpg-12.12"][..]),
    ] {
        let made = between(limit);
        let joint = &made.joints[0];
        let result = optimize(&made, &own);
        let design = &result.joints[0].candidates[0];
        assert!(design.gear.is_none());
        let place = joint.family_map().unwrap().place(design.optimum.ratio).unwrap();
        match (place, ids) {
            (FamilyPlace::At(point), [id]) => assert_eq!(&point.id, id),
            (FamilyPlace::Between(a, b), [x, y]) => assert_eq!((&*a.id, &*b.id), (*x, *y)),
            (place, _) => panic!("{limit}: {place:?}"),
        }
        assert!(ratio == 0.0 || (design.optimum.ratio - ratio).abs() < 1e-9);
        // What no point says is not known: it is not kept, and not "not asked for" as of a gear that the user describes.
        let unchecked: Vec<&str> = design.unchecked.iter().map(|(limit, _)| *limit).collect();
        assert!(unchecked.contains(&"gear_continuous_torque") && unchecked.contains(&"gear_inertia"), "{unchecked:?}");
    }
    // The mass between two points, by hand: 694 g at 11.41, 716 g at 12.12, in N².
    let made = between("actuator_mass = \"710 g\"");
    let (a, b) = (11.410_714_285_7_f64, 12.118_226_601_0_f64);
    let share = (0.710 - 0.694) / (0.716 - 0.694);
    let by_hand = (a * a + share * (b * b - a * a)).sqrt();
    // The limit holds for the catalogue's motor, which weighs as much as that of the designs.
    let motor = own.motor("t-motor-u8-lee").unwrap();
    assert_eq!(motor.mass, Some(0.240));
    assert!((optimize(&made, &own).joints[0].candidates[0].optimum.ratio / by_hand - 1.0).abs() < 1e-9);
}

/// A limit on what no point says cannot be judged, so no motor is a choice.
#[test]
fn what_a_family_does_not_say_is_no_choice_under_a_limit() {
    let own = catalog();
    for family in ["family = [\"compact-u8-*\"]", "family = [\"compact-u8-sspg\"]\nbetween = true"] {
        for limit in [
            "reflected_inertia = \"1 kg*m^2\"",
            "outer_diameter = \"1 m\"",
            "max_backlash = \"1 deg\"",
            "lead_time = \"900 d\"",
        ] {
            let limits = format!("winding_temperature = \"110 degC\"\n{limit}");
            let changes = [("family = [\"compact-u8-*\"]", family), ("winding_temperature = \"110 degC\"", &limits)];
            let made = settled(robot(&changes), &own).unwrap();
            let result = optimize(&made, &own);
            assert!(result.joints[0].candidates.is_empty(), "{family} {limit}");
            assert_eq!(result.joints[0].unjudged.len(), 1, "{family} {limit}");
        }
    }
}

#[test]
fn families_that_do_not_go_together_are_refused() {
    let own = catalog();
    let steel = r#"
name = "steel-u8"
kind = "planetary"
motor = "t-motor-u8*"
stress_limit = "400 MPa"
mass_covers = "gear"
source = "a test"
source_kind = "derived"
[[point]]
ratio = 4
efficiency = 0.95
mass = "100 g"
"#;
    let with = |text: &str| {
        let sources = Catalog::builtin_sources().into_iter().chain([Arc::new(Source::new("steel.toml", text))]);
        Catalog::from_sources(sources.collect()).unwrap_or_else(|e| panic!("{}", e[0])).free(false)
    };
    let refused = |changes: &[(&str, &str)], catalog: &Catalog| settled(robot(changes), catalog).unwrap_err();
    let both = ("family = [\"compact-u8-*\"]", "family = [\"compact-u8-sspg\", \"steel-u8\"]");
    let why = refused(&[both], &with(steel));
    assert!(
        why.contains("`compact-u8-sspg` (70 MPa) and `steel-u8` (400 MPa) are made for two stress limits"),
        "{why}"
    );
    // One of which it is not known is another rule as well.
    let unknown = steel.replace("stress_limit = \"400 MPa\"\n", "");
    let why = refused(&[both], &with(&unknown));
    assert!(why.contains("`steel-u8` (no stress limit that is known)"), "{why}");
    // The same limit goes.
    assert!(settled(robot(&[both]), &with(&steel.replace("400 MPa", "7e7 Pa"))).is_ok());
    for (family, told) in [
        (
            "family = [\"compact-u8-ssp\"]",
            "no gear family of the catalogue matches `compact-u8-ssp`; did you mean `compact-u8-sspg`?",
        ),
        (
            "family = [\"compact-u8-*\"]\nbetween = true",
            "`between = true` takes one family; compact-u8-* names compact-u8-cpg, compact-u8-dspg, compact-u8-sspg",
        ),
    ] {
        let why = refused(&[("family = [\"compact-u8-*\"]", family)], &own);
        assert!(why.contains(told), "{why}");
    }
    let why = refused(&[("motors = [\"t-motor-u8*\"]", "motors = [\"maxon-*\"]")], &own);
    assert!(why.contains("is made for t-motor-u8, t-motor-u8-lee, and none of the joint's motors is that"), "{why}");
    let alone = ("family = [\"compact-u8-*\"]", "family = [\"steel-u8\"]\nbetween = true");
    let why = refused(&[alone], &with(steel));
    assert!(why.contains("no ratios between the points of `steel-u8`: it has one point alone"), "{why}");
    let more = |columns: &str| format!("{steel}\n[[point]]\nratio = 6\n{columns}");
    let why = refused(&[alone], &with(&more("efficiency = 0.9")));
    assert!(why.contains("`mass` is known of 1 of 2 points alone"), "{why}");
    let why = refused(&[alone], &with(&more("efficiency = 0.9\nmass = \"120 g\"\nstarting_torque = \"0.1 N*m\"")));
    assert!(why.contains("`starting_torque` is not interpolated"), "{why}");
    let side = "winding_temperature = \"110 degC\"\naxial_length = \"90 mm\"\narrangement = \"side_by_side\"";
    let why = refused(&[("winding_temperature = \"110 degC\"", side)], &own);
    assert!(why.contains("are those of motor and gear one behind the other"), "{why}");
}

/// The catalogue's reader and the requirement's refuse, each at its place.
#[test]
fn mistakes_of_a_family_have_their_place() {
    let good = r#"name = "mine"
kind = "planetary"
motor = "t-motor-u8*"
stages = 1
stress_limit = "70 MPa"
mass_covers = "actuator"
motor_mass = "240 g"
source = "a test"
source_kind = "derived"
[[point]]
ratio = 4
efficiency = 0.95
mass = "500 g"
[[point]]
ratio = 5
efficiency = 0.94
mass = "520 g"
"#;
    let read = |text: String| Catalog::from_sources(vec![Arc::new(Source::new("mine.toml", text))]);
    let family = &read(good.into()).unwrap_or_else(|e| panic!("{}", e[0])).families[0];
    assert_eq!(family.points.iter().map(|p| p.id.as_str()).collect::<Vec<_>>(), ["mine-4", "mine-5"]);
    // Points in any order are one family.
    let swapped = good.replacen("ratio = 4", "ratio = 6", 1);
    let family = &read(swapped).unwrap().families[0];
    assert_eq!(family.points.iter().map(|p| p.ratio).collect::<Vec<_>>(), [5.0, 6.0]);
    for (from, to, told) in [
        ("ratio = 5", "ratio = 4", "the ratio 4 is there twice"),
        ("efficiency = 0.94", "efficiency = 1.04", "`efficiency` of [[point]] is out of range"),
        ("efficiency = 0.94", "efficiency = nan", "`efficiency`"),
        ("mass_covers = \"actuator\"\nmotor_mass = \"240 g\"\n", "", "`mass_covers` is missing"),
        ("motor_mass = \"240 g\"\n", "", "`motor_mass` is missing"),
        ("mass_covers = \"actuator\"", "mass_covers = \"gear\"", "does not say that one is in it"),
        ("mass = \"520 g\"", "mass = \"240 g\"", "is not more than that of its motor"),
        ("mass = \"520 g\"", "mass = \"-520 g\"", "`mass` of [[point]] is out of range"),
        ("mass = \"520 g\"", "mass = 520", "`mass` of [[point]]"),
        (
            "mass = \"520 g\"",
            "mass = \"520 g\"\nstress_limit = \"400 MPa\"",
            "this point is made for 400 MPa, the family for 70 MPa",
        ),
        ("stress_limit = \"70 MPa\"", "stress_limit = \"70 N\"", "is not a unit of stress"),
        ("mass = \"520 g\"", "mas = \"520 g\"", "unknown key `mas`"),
        ("mass = \"520 g\"", "mass = \"520 g\"\nkind = \"belt\"", "a point has no `kind`"),
        ("ratio = 5\n", "", "`ratio` of [[point]] is missing"),
        ("kind = \"planetary\"\n", "", "`kind` is missing"),
        ("source = \"a test\"\n", "", "`source` is missing"),
        ("source_kind = \"derived\"\n", "", "`source_kind` is missing"),
        ("name = \"mine\"", "name = \"My family\"", "lower-case letters"),
        ("name = \"mine\"\n", "", "`name` is missing"),
        ("stages = 1", "stage = 1", "unknown key `stage`"),
    ] {
        assert!(good.contains(from), "{from}");
        let errors = read(good.replacen(from, to, 1)).expect_err(told);
        let all: Vec<&str> = errors[0].problems.iter().map(|p| p.message.as_str()).collect();
        assert!(all.iter().any(|message| message.contains(told)), "{told}: {all:?}");
        assert!(errors[0].problems.iter().all(|p| p.span.is_some() || p.message.contains("missing")), "{told}");
    }
    let twice = [Source::new("a.toml", good), Source::new("b.toml", good)].map(Arc::new);
    let errors = Catalog::from_sources(twice.to_vec()).unwrap_err();
    assert!(errors[0].problems[0].message.contains("is in two files"), "{}", errors[0]);
    // The requirement.
    for (from, to, told) in [
        (
            "family = [\"compact-u8-*\"]",
            "family = [\"compact-u8-*\"]\nratio = { min = 3, max = 9 }",
            "a joint has `ratio` or `family`, not both",
        ),
        (
            "family = [\"compact-u8-*\"]",
            "family = [\"compact-u8-*\"]\ngears = [\"*\"]",
            "a joint has `gears` or `family`, not both",
        ),
        ("family = [\"compact-u8-*\"]", "family = \"compact-u8-*\"", "`family`"),
        ("family = [\"compact-u8-*\"]", "family = [\"a\"]\nbetween = 1", "`between`"),
        ("family = [\"compact-u8-*\"]", "ratio = { min = 3, max = 9 }\nbetween = true", "unknown key `between`"),
        (
            "family = [\"compact-u8-*\"]",
            "family = [\"a\"]\ngear = { efficiency = 0.9 }",
            "`family` names gears that have their numbers",
        ),
        (
            "family = [\"compact-u8-*\"]",
            "family = [\"a\"]\nbetween = true\nefficiency_covers = \"load_and_gear\"",
            "is not for ratios between",
        ),
    ] {
        let text = ROBOT.replacen(from, to, 1);
        let errors = requirement::read_source(&Source::new("robot.toml", text).into()).expect_err(told);
        let all: Vec<&str> = errors[0].problems.iter().map(|p| p.message.as_str()).collect();
        assert!(all.iter().any(|message| message.contains(told)), "{told}: {all:?}");
    }
    for (limit, told) in [
        ("life = \"100 h\"", "`between` and `life` of [joint.limits] do not go together"),
        ("max_backdriving_torque = \"1 N*m\"", "`between` and `max_backdriving_torque`"),
    ] {
        let limits = format!("winding_temperature = \"110 degC\"\n{limit}");
        let text = ROBOT.replacen("family = [\"compact-u8-*\"]", "family = [\"a\"]\nbetween = true", 1).replacen(
            "winding_temperature = \"110 degC\"",
            &limits,
            1,
        );
        let errors = requirement::read_source(&Source::new("robot.toml", text).into()).expect_err(told);
        let all: Vec<&str> = errors[0].problems.iter().map(|p| p.message.as_str()).collect();
        assert!(all.iter().any(|message| message.contains(told)), "{told}: {all:?}");
    }
    let budget = ROBOT.replacen("[bus]", "[budget]\npower = \"900 W\"\n[bus]", 1);
    let budget = budget.replacen("family = [\"compact-u8-*\"]", "family = [\"a\"]\nbetween = true", 1);
    let errors = requirement::read_source(&Source::new("robot.toml", budget).into()).unwrap_err();
    let told = &errors[0].problems[0].message;
    assert!(told.contains("has ratios `between` the points of a family and shares a budget of power"), "{told}");
}

/// The kind of the joint before and behind the catalogue.
#[test]
fn a_family_becomes_a_free_ratio_where_it_may_lie_between() {
    let own = catalog();
    let made =
        settled(robot(&[("family = [\"compact-u8-*\"]", "family = [\"compact-u8-sspg\"]\nbetween = true")]), &own);
    let joint = &made.unwrap().joints[0];
    let RatioChoice::Continuous { min, max } = joint.ratio else { panic!("{:?}", joint.ratio) };
    assert!((min - 4.451_612_903_23).abs() < 1e-9 && max == 7.0);
    let map = joint.family_map().unwrap();
    assert!(map.place(4.0).is_none() && map.place(7.1).is_none());
    // At a point its own efficiency; just beside it that of the worse neighbour.
    let at = |ratio: f64| map.gear(&joint.gear, ratio).efficiency;
    for (ratio, efficiency) in
        [(5.5, 0.953), (5.5_f64.next_up(), 0.946), (5.4, 0.953), (6.0, 0.946), (6.3, 0.946), (7.0, 0.946)]
    {
        assert!((at(ratio) - efficiency).abs() < 1e-12, "{ratio} {}", at(ratio));
    }
    assert!((map.gear(&joint.gear, 6.521_739_130_43).efficiency - 0.955).abs() < 1e-12);
}
