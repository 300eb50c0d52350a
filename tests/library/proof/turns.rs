//! What another number of turns does for a motor, against a scan over ratios and turns that shares no code with it: a
//! motor is wound by hand, and the raw waveforms are looked at.

use gearwise::catalog::{Catalog, Motor};
use gearwise::design::turns::{Rewinding, rewinding};
use gearwise::design::{JointDemand, Site};
use gearwise::requirement::{Quantity, RatioChoice};
use rayon::prelude::*;

use crate::cases::{are_all, cases, long_cases};
use crate::raw::{Case, draw};
use crate::solved;

/// A motor with `a` times its turns, number by number.
pub fn wound(motor: &Motor, a: f64) -> Motor {
    let mut motor = motor.clone();
    motor.resistance *= a * a;
    motor.inductance = motor.inductance.map(|l| l * a * a);
    motor.torque_constant *= a;
    motor.back_emf_constant *= a;
    motor.peak_current = motor.peak_current.map(|i| i / a);
    motor.continuous_current = motor.continuous_current.map(|i| i / a);
    motor
}

pub fn with_turns(case: &Case, a: f64) -> Case {
    Case::new(wound(&case.motor, a), case.robot.clone(), case.raw.clone())
}

/// What came of a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Came {
    /// `near`: what was seen is at most 5 % better.
    Found {
        proved: bool,
        near: bool,
    },
    Useless,
    /// `seen`: the scan found some.
    NoneFound {
        seen: bool,
    },
    Apart,
}

/// Ratios and turns that are looked at.
const RATIOS: i32 = 240;
const TURNS: i32 = 60;

/// Of some joints the windings' own voltage has a limit, of others the drive's current for ever: both go with the turns.
pub fn with_limits_of_turns(case: &mut Case, i: u64) {
    let bus = &mut case.robot.bus;
    if i % 5 == 2 {
        bus.max_voltage = Some(bus.voltage * [1.01, 1.3, 3.0][(i / 5 % 3) as usize]);
    }
    if i % 7 == 3 {
        let most = case.robot.joints[0].drive_current.or(bus.drive_current).unwrap_or(30.0);
        bus.drive.continuous_current = Some(most * [0.05, 0.3, 0.9][(i / 7 % 3) as usize]);
    }
}

fn look(i: u64, convex: bool) -> (Came, Vec<String>) {
    let mut case = draw(i, convex);
    // A supply that is far too low or far too high as often as one that suits.
    case.robot.bus.voltage *= [0.05, 0.3, 1.0, 3.0][(i % 4) as usize];
    with_limits_of_turns(&mut case, i);
    let joint = &case.robot.joints[0];
    let RatioChoice::Continuous { min, max } = joint.ratio else { unreachable!() };
    let counts_current = joint.objective.weight(Quantity::PeakCurrent) > 0.0;
    let catalog = Catalog::of(vec![case.motor.clone()], Vec::new());
    let demand = JointDemand::new(joint, &catalog);
    let site = Site::new(&case.robot, joint, &demand);
    let told = rewinding(site, &catalog.motors[0], &catalog, false);
    let mut wrong = Vec::new();
    let mut must = |holds: bool, what: String| {
        if !holds {
            wrong.push(format!("case {i}: {what}"));
        }
    };
    // All ratios and turns that keep every limit, with their objective; the wound cases are made once.
    let turns: Vec<Case> =
        (0..=TURNS).map(|k| with_turns(&case, 0.02 * 2500.0_f64.powf(f64::from(k) / f64::from(TURNS)))).collect();
    let ratios = (0..=RATIOS).map(|k| min * (max / min).powf(f64::from(k) / f64::from(RATIOS)));
    let kept: Vec<(f64, f64)> = ratios
        .flat_map(|n| turns.iter().map(move |wound| (n, wound)))
        .filter(|(n, wound)| wound.worst(*n).0 <= -1e-9)
        .map(|(n, wound)| (n, wound.look(n).objective))
        .collect();
    let came = match &told {
        Rewinding::Found(other) => {
            let range = other.turns;
            let excess = |a: f64| with_turns(&case, a).worst(other.ratio);
            let ends = [range.min.max(1e-3), range.max.min(1e3)];
            for a in [ends[0] * (1.0 + 1e-9), (ends[0] * ends[1]).sqrt(), ends[1] * (1.0 - 1e-9)] {
                must(excess(a).0 <= 1e-6, format!("{a} turns at N {}: {:?}", other.ratio, excess(a)));
            }
            if range.min > 0.0 {
                let (over, limit) = excess(range.min * 0.999);
                let is_current =
                    matches!(limit, "peak_current" | "torque_bandwidth_current" | "drive_continuous_current");
                must(over > 1e-4 && is_current, format!("fewer turns: {over} {limit}, by {:?}", range.min_by));
            }
            if range.max.is_finite() {
                let (over, limit) = excess(range.max * 1.001);
                must(over > 1e-4 && limit.contains("voltage"), format!("more turns: {over} {limit}"));
            }
            if let (Some(objective), false) = (other.objective, counts_current) {
                let at = with_turns(&case, (ends[0] * ends[1]).sqrt()).look(other.ratio).objective;
                must((at - objective).abs() <= 1e-8 * at.abs().max(1e-9), format!("objective {objective}, {at}"));
                let best = kept.iter().map(|k| k.1).fold(f64::INFINITY, f64::min);
                let size = objective.abs().max(best.abs());
                let is_least = objective <= best + 1e-6 * size;
                must(!other.proved || is_least, format!("{objective} is proved, {best} was seen"));
                return (Came::Found { proved: other.proved, near: objective <= best + 0.05 * size }, wrong);
            }
            Came::Found { proved: other.proved, near: true }
        }
        Rewinding::Useless(why) => {
            must(kept.is_empty(), format!("no turns: {why:?}, but {:?}", kept.first()));
            Came::Useless
        }
        Rewinding::NoneFound => Came::NoneFound { seen: !kept.is_empty() },
        Rewinding::Unjudged(_) | Rewinding::NotAsked(_) => Came::Apart,
    };
    (came, wrong)
}

#[test]
fn the_best_over_turns_agrees_with_a_scan_of_ratios_and_turns() {
    let drawn = long_cases(0, 600).map(|i| (i, true)).chain(long_cases(100_000, 200).map(|i| (i, false)));
    let found: Vec<(Came, Vec<String>)> = drawn.collect::<Vec<_>>().into_par_iter().map(|(i, c)| look(i, c)).collect();
    let wrong: Vec<&String> = found.iter().flat_map(|f| &f.1).collect();
    let count = |came: &dyn Fn(Came) -> bool| found.iter().filter(|f| came(f.0)).count();
    let (proved, useless) = (count(&|c| matches!(c, Came::Found { proved: true, .. })), count(&|c| c == Came::Useless));
    let (looked, none) =
        (count(&|c| matches!(c, Came::Found { proved: false, .. })), count(&|c| matches!(c, Came::NoneFound { .. })));
    let far = count(&|c| matches!(c, Came::Found { near: false, .. }));
    let missed = count(&|c| c == Came::NoneFound { seen: true });
    println!(
        "{} joints: {proved} proved, {looked} found ({far} of them more than 5 % above what was seen), {useless} that no turns help, {none} without either ({missed} of them with turns that were seen)",
        found.len()
    );
    assert!(wrong.is_empty(), "{} disagree: {:#?}", wrong.len(), &wrong[..wrong.len().min(12)]);
    // What is only found is called so: it may be missed, and seldom is.
    assert!(far * 20 <= looked.max(20) && missed * 10 <= none.max(10), "{far} of {looked}, {missed} of {none}");
    if are_all() {
        assert!(proved > 80 && looked > 20 && useless > 50, "{proved} {looked} {useless}");
    }
}

/// With `a` times the turns, `a` times the voltage and one `a`-th of the drive's current nothing else changes.
#[test]
fn a_rewound_motor_at_another_voltage_is_the_same_motor() {
    let mut solved_ones = 0;
    for i in cases(500_000, 200) {
        let case = draw(i, true);
        let a = [0.31, 0.5, 1.9, 3.7][(i % 4) as usize];
        let mut robot = case.robot.clone();
        robot.bus.voltage *= a;
        robot.bus.current = robot.bus.current.map(|i| i / a);
        robot.bus.drive_current = robot.bus.drive_current.map(|i| i / a);
        robot.joints[0].drive_current = robot.joints[0].drive_current.map(|i| i / a);
        let mut motor = case.motor.rewound(a).expect("it can be rewound");
        assert_eq!(motor.id, format!("{}:{a}", case.motor.id));
        // No joint lists it.
        motor.wound = None;
        let by_hand = wound(&case.motor, a);
        for (law, hand) in [
            (motor.resistance, by_hand.resistance),
            (motor.torque_constant, by_hand.torque_constant),
            (motor.back_emf_constant, by_hand.back_emf_constant),
            (motor.inductance.unwrap_or(0.0), by_hand.inductance.unwrap_or(0.0)),
            (motor.peak_current.unwrap_or(0.0), by_hand.peak_current.unwrap_or(0.0)),
            (motor.continuous_current.unwrap_or(0.0), by_hand.continuous_current.unwrap_or(0.0)),
        ] {
            assert!((law - hand).abs() <= 1e-12 * hand.abs(), "case {i}: {law} {hand}");
        }
        let near = |x: f64, y: f64| (x - y).abs() <= 1e-7 * x.abs().max(y.abs());
        match (solved::solve(&case.motor, &case.robot), solved::solve(&motor, &robot)) {
            (Ok(own), Ok(other)) => {
                let (a_loss, b_loss) = (own.evaluation.copper_loss, other.evaluation.copper_loss);
                let ends = own.optimum.windows.iter().zip(&other.optimum.windows);
                let same = ends.clone().all(|(x, y)| near(x.min, y.min) && near(x.max, y.max));
                assert!(same && own.optimum.windows.len() == other.optimum.windows.len(), "case {i}");
                let objective = &case.robot.joints[0].objective;
                if objective.weight(Quantity::PeakCurrent) == 0.0 {
                    assert!(near(a_loss, b_loss) || own.optimum.objective == 0.0, "case {i}: {a_loss} {b_loss}");
                }
                solved_ones += 1;
            }
            (Err(_), Err(_)) => {}
            (own, other) => panic!("case {i}: {:?} {:?}", own.is_ok(), other.is_ok()),
        }
    }
    assert!(solved_ones > 15, "{solved_ones}");
}

/// A requirement's joint with a list of turns, on the shipped catalogue.
fn listed(turns: &str) -> (gearwise::requirement::Robot, Catalog) {
    let text = format!(
        "name = \"r\"\nbus = {{ voltage = \"60 V\", drive_current = \"80 A\" }}\n[[joint]]\nname = \"j\"\nratio = {{ min = 3, max = 30 }}\nobjective = \"copper_loss\"\nmotor_drag = \"off\"\nmotors = [\"tq-robodrive-ilm-70x18\", \"t-motor-ri50\"]\n{turns}\n\
         points = [{{ torque = \"10 N*m\", speed = \"6 rad/s\", duration = \"1 s\" }}, {{ torque = \"2 N*m\", speed = \"14 rad/s\", duration = \"1 s\" }}]\n"
    );
    let source = std::sync::Arc::new(gearwise::input::Source::new("r.toml", text));
    let robot = gearwise::requirement::read_source(&source).unwrap_or_else(|e| panic!("{}", e[0]));
    let catalog = Catalog::builtin().unwrap().free(false).with_turns(&robot.listed_turns());
    (robot, catalog)
}

/// The choice among windings is the best of the motors wound by hand; each is named by its row and its turns.
#[test]
fn listed_turns_are_motors_like_any_other() {
    let best = |turns: &str| {
        let (robot, catalog) = listed(turns);
        let result = gearwise::design::optimize::optimize(&robot, &catalog);
        let design = result.joints[0].designs().next().expect("one will do");
        (design.motor.id.clone(), design.optimum.objective, design.assumed.iter().any(|(name, _)| *name == "turns"))
    };
    let builtin = Catalog::builtin().unwrap();
    let by_hand = |turns: &[f64]| {
        let (robot, _) = listed("");
        let of = |id: &str, a: f64| {
            let motor = wound(builtin.motor(id).unwrap(), a);
            solved::solve(&motor, &robot).ok().map(|design| (format!("{id} {a}"), design.optimum.objective))
        };
        let ids = ["tq-robodrive-ilm-70x18", "t-motor-ri50"];
        let all = ids.iter().flat_map(|id| turns.iter().filter_map(move |a| of(id, *a)));
        all.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap()
    };
    for (key, turns) in [("", vec![1.0]), ("turns = [1, 0.5]", vec![1.0, 0.5]), ("turns = [0.45]", vec![0.45])] {
        let (id, objective, said) = best(key);
        let (named, least) = by_hand(&turns);
        assert!((objective / least - 1.0).abs() < 1e-6, "{key}: {id} {objective}, {named} {least}");
        assert_eq!(id.contains(':'), said, "{id}: what is another winding is said to be one, and nothing else is");
        assert!(id.contains(':') == (key == "turns = [0.45]") || key.contains("[1,"), "{key}: {id}");
    }
}

/// A star connected in delta: K/√3, R/3, L/3. And nothing is chosen that no joint lists.
#[test]
fn a_delta_of_a_star_has_a_third_of_its_resistance() {
    let (robot, catalog) = listed("turns = [1, 0.5773502691896258]");
    let row = catalog.motor("t-motor-ri50").unwrap();
    let delta = catalog.motor("t-motor-ri50:0.5773502691896258").unwrap();
    assert!((3.0 * delta.resistance / row.resistance - 1.0).abs() < 1e-12);
    assert!((3.0_f64.sqrt() * delta.torque_constant / row.torque_constant - 1.0).abs() < 1e-12);
    assert!((3.0 * delta.inductance.unwrap() / row.inductance.unwrap() - 1.0).abs() < 1e-12);
    assert!(robot.joints[0].motors.allows(delta) && robot.joints[0].motors.allows(row));
    let (plain, _) = listed("");
    assert!(!plain.joints[0].motors.allows(delta) && plain.joints[0].motors.allows(row));
    let (only, _) = listed("turns = [0.5773502691896258]");
    assert!(only.joints[0].motors.allows(delta) && !only.joints[0].motors.allows(row));
    // Insides of modules and fitted motors have no other turns.
    assert!(catalog.aside.iter().all(|motor| motor.wound.is_none()));
}

#[test]
fn turns_that_are_none_are_refused_with_their_place() {
    for (turns, what) in [
        ("turns = []", "lists nothing"),
        ("turns = [1, 1]", "listed twice"),
        ("turns = [0.01]", "no winding"),
        ("turns = [-1]", "turns"),
        ("turns = [\"delta\"]", "turns"),
    ] {
        let text = format!(
            "name = \"r\"\nbus = {{ voltage = \"24 V\" }}\n[[joint]]\nname = \"j\"\nratio = {{ min = 3, max = 30 }}\n{turns}\npoints = [{{ torque = \"3 N*m\", speed = \"6 rad/s\" }}]\n"
        );
        let source = std::sync::Arc::new(gearwise::input::Source::new("r.toml", text));
        let errors = gearwise::requirement::read_source(&source).expect_err(turns);
        let text = errors[0].to_string();
        assert!(text.contains(what) && text.contains("turns"), "{turns}: {text}");
    }
}
