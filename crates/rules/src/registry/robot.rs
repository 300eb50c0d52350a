//! Rules about the robot as a whole, and about the rules file.

use crate::facts::RobotFacts;
use crate::place::Place;
use crate::rule::{Remark, Rule, Severity, Test};
use gearwise_model::words::number;
pub use gearwise_select::robot::{Draws, most_returned, peak_power, sag};

pub(super) const MASS_BUDGET: Rule = Rule {
    code: "GW040",
    name: "mass-budget",
    summary: "all actuators together stay within the mass budget",
    severity: Severity::Error,
    what: "Adds up the mass of motor and gear over all joints, each as often as the robot has it, and compares it with `actuator_mass` of the requirement's [budget].",
    why: "The motions were computed with a robot of a certain mass; heavier actuators make every torque too small.",
    example: "Twelve actuators of 520 g with a budget of 6 kg.",
    fix: "Lighter actuators where loss costs least (`optimize --pareto loss,mass`), or a new budget and new motions.",
    test: Test::Robot(mass_budget),
};

fn mass_budget(facts: &RobotFacts) -> Vec<Remark> {
    let Some(budget) = facts.design.robot.budget.actuator_mass else { return Vec::new() };
    let asked = Some(Place::RobotKey(&["budget", "actuator_mass"]));
    match facts.total(|e| e.evaluation.mass) {
        Some(mass) if mass > budget * (1.0 + 1e-9) => {
            let message = format!("all actuators weigh {} kg, the budget is {} kg", number(mass), number(budget));
            let remark = Remark::new(message, "mass", Place::Design);
            vec![Remark { asked, value: Some(mass), bound: Some(budget), ..remark }]
        }
        Some(_) => Vec::new(),
        None => {
            let message = "the mass budget cannot be checked: the mass of a motor or gear is not known";
            vec![Remark { asked, bound: Some(budget), ..Remark::new(message, "mass", Place::Design) }]
        }
    }
}

pub(super) const DISTINCT_MOTORS: Rule = Rule {
    code: "GW041",
    name: "distinct-motors",
    summary: "no more different motors than allowed",
    severity: Severity::Error,
    what: "Counts the different motors of the design and compares with `max_distinct_motors` of the requirement's [budget].",
    why: "Each further type is a further part to buy, to stock, to wind and to tune.",
    example: "Three motors where two are allowed.",
    fix: "Use one of the others again: `optimize` lists what each would cost at the joint.",
    test: Test::Robot(|facts| {
        let Some(most) = facts.design.robot.budget.max_distinct_motors else { return Vec::new() };
        let motors = facts.motors();
        if motors.len() <= most as usize {
            return Vec::new();
        }
        let message = format!("{} different motors, {most} are allowed: {}", motors.len(), motors.join(", "));
        let asked = Some(Place::RobotKey(&["budget", "max_distinct_motors"]));
        let (value, bound) = (Some(motors.len() as f64), Some(f64::from(most)));
        vec![Remark { asked, value, bound, ..Remark::new(message, "motors", Place::Design) }]
    }),
};

pub(super) const POWER_BUDGET: Rule = Rule {
    code: "GW043",
    name: "power-budget",
    summary: "all joints together stay within the power of the bus",
    severity: Severity::Error,
    what: "Adds up the power that the joints draw, instant by instant where their motions share a period (phases included), and compares the largest sum with `power` and `current` of the requirement's [budget]. Joints without a common time base count with their peaks.",
    why: "The bus is one: a battery or supply that is asked for more sags or shuts down, and every joint with it.",
    example: "Four knees that all push at the same instant, on a bus that feeds two.",
    fix: "`optimize` finds the combination that keeps the budget; or shift the phases, or a larger supply.",
    test: Test::Robot(power_budget),
};

fn power_budget(facts: &RobotFacts) -> Vec<Remark> {
    let robot = &facts.design.robot;
    let Some(budget) = robot.shared_power() else { return Vec::new() };
    let of_power = robot.budget.power.is_some();
    let asked = Some(Place::RobotKey(if of_power { &["budget", "power"] } else { &["budget", "current"] }));
    let Some(all) = draws(facts) else { return Vec::new() };
    let powers: Vec<Vec<f64>> = all.into_iter().map(|draws| draws.power).collect();
    let peak = peak_power(robot, &powers);
    if peak <= budget * (1.0 + 1e-9) {
        return Vec::new();
    }
    let message = format!("all joints together draw {} W, the bus has {} W", number(peak), number(budget));
    vec![Remark { asked, value: Some(peak), bound: Some(budget), ..Remark::new(message, "power", Place::Design) }]
}

/// What each joint draws; `None` where one cannot be evaluated, which its own rule tells.
fn draws(facts: &RobotFacts) -> Option<Vec<Draws>> {
    let of = |name: &str| {
        let joint = facts.joints.iter().find(|facts| facts.choice.joint.name == name)?;
        Some(joint.examined.as_ref().ok()?.draws.clone())
    };
    facts.design.robot.joints.iter().map(|joint| of(&joint.name)).collect()
}

pub(super) const REGENERATION_BUDGET: Rule = Rule {
    code: "GW045",
    name: "regeneration-budget",
    summary: "what comes back from all joints together stays within what the bus takes",
    severity: Severity::Error,
    what: "Adds up what the joints give back to the bus, less what others draw at that instant, where their motions share a period (phases included), and compares the largest sum with `regeneration` of the requirement's [budget] and the `brake_power` of its [bus]. A winding at its reference temperature gives back most. Joints without a common time base count at their worst instants.",
    why: "The limit `regeneration` of the [bus] is one of each joint alone. Four legs that land together give back four times as much, and a battery that is full or a supply that takes nothing lets the bus voltage rise until a drive trips.",
    example: "Twelve joints that each keep 40 W, on a supply that takes 100 W back.",
    fix: "`optimize` finds the combination that keeps it; or a brake (`brake_power`), more capacitance, or shifted phases.",
    test: Test::Robot(regeneration_budget),
};

fn regeneration_budget(facts: &RobotFacts) -> Vec<Remark> {
    let robot = &facts.design.robot;
    let Some(most) = robot.shared_regeneration() else { return Vec::new() };
    let Some(all) = draws(facts) else { return Vec::new() };
    let returned = most_returned(robot, &all);
    if returned <= most + 1e-9 * most.max(1.0) {
        return Vec::new();
    }
    let message = format!("all joints together give back {} W, the bus takes {} W", number(returned), number(most));
    let asked = Some(Place::RobotKey(&["budget", "regeneration"]));
    vec![Remark {
        asked,
        value: Some(returned),
        bound: Some(most),
        ..Remark::new(message, "regeneration", Place::Design)
    }]
}

/// The supply under all joints together.
pub(super) const SUPPLY_SAG: Rule = Rule {
    code: "GW044",
    name: "supply-sag",
    summary: "under all joints together the supply leaves each drive the voltage that it needs",
    severity: Severity::Error,
    what: "With `internal_resistance` in the requirement's [bus] it adds up the power that the joints draw, instant by instant where their motions share a period (phases included), and compares the voltage that the bus falls to with what each drive needs then. Joints without a common time base count at their worst instants; power that a joint gives back is not counted on.",
    why: "The limit `voltage` of a joint counts the sag of its own power alone. A pack that feeds one knee well may leave all four of them too little.",
    example: "Four knees that push off at the same instant on a pack of 100 mohm: each keeps its voltage alone, together they do not.",
    fix: "`optimize` finds the ratios and motors that keep it; or a supply of less resistance or more voltage, or shift the phases.",
    test: Test::Robot(supply_sag),
};

fn supply_sag(facts: &RobotFacts) -> Vec<Remark> {
    let robot = &facts.design.robot;
    let Some(sag) = draws(facts).and_then(|all| sag(robot, &all)) else { return Vec::new() };
    if sag.left >= -1e-9 {
        return Vec::new();
    }
    let joint = &robot.joints[sag.joint].name;
    let bus = match sag.lowest {
        Some(lowest) => format!("all joints together let the bus fall to {} V", number(lowest)),
        None => "the supply cannot give what all joints together take".into(),
    };
    let message = format!("{bus}: {joint} is short of {} % of the supply's voltage", number(-100.0 * sag.left));
    let asked = Some(Place::RobotKey(&["bus", "internal_resistance"]));
    vec![Remark { asked, value: Some(-sag.left), bound: Some(0.0), ..Remark::new(message, "sag", Place::Design) }]
}

/// An exception that excepts nothing.
pub const UNUSED_ALLOW: Rule = Rule {
    code: "GW301",
    name: "unused-allow",
    summary: "every exception of the rules file excepts something",
    severity: Severity::Warning,
    what: "Reports an [[allow]] of the rules file that met no finding.",
    why: "An exception that outlives its reason hides the next finding of that rule.",
    example: "[[allow]] of voltage-headroom at the knee after the bus went from 24 V to 48 V.",
    fix: "Remove it, or correct its `joints` or `subject`.",
    test: Test::RulesFile,
};

/// A pattern of joints that matches none.
pub const SELECTS_NOTHING: Rule = Rule {
    code: "GW302",
    name: "selects-nothing",
    summary: "every pattern of joints in the rules file matches a joint",
    severity: Severity::Warning,
    what: "Reports a pattern in `joints` of the rules file that matches no joint of the robot.",
    why: "A rule for a joint that is not there (a typo, a joint renamed) checks nothing, silently.",
    example: "joints = [\"kneee*\"] for a robot whose joint is called `knee`.",
    fix: "Correct the pattern; `*` matches any run of characters.",
    test: Test::RulesFile,
};
