//! The choice for a whole robot: which design at which joint, what it keeps, how sure it is, what comes next
//! and what the budgets cost.

use serde_json::{Value, json};

use super::table::{table, wrap};
use super::{currents, different_motors, number, optional};
use crate::design::optimize::Design;
use crate::design::robot::{Change, Choice, Combination, Wanting};
use crate::requirement::{Joint, Regeneration, Robot};

/// For people.
pub fn text(choice: &Choice) -> String {
    let robot = choice.robot;
    let mut out = format!("The whole robot, {}:\n", aim(choice));
    out.push_str(&format!("  {}\n", wrap(&kept(choice), 4)));
    let Some(best) = choice.combinations.first() else {
        out.push_str(&wanting_text(choice));
        out.push_str(&super::unjudged::robot_text(choice));
        return out;
    };
    out.push('\n');
    out.push_str(&designs(robot, best));
    out.push_str(&format!("\n  {}\n", wrap(&sums(choice, best), 4)));
    out.push_str(&format!("  {}\n", wrap(&proof(choice), 4)));
    if let Some(price) = best.power_price.filter(|p| *p < 0.0) {
        let line = format!("the bus binds: one watt more is worth {} {}", number(-price), unit(choice));
        out.push_str(&format!("  {}\n", wrap(line.trim_end(), 4)));
    }
    if choice.combinations.len() > 1 {
        out.push_str("\n  Next best, each with another motor somewhere:\n");
        for (place, next) in choice.combinations.iter().enumerate().skip(1) {
            let line = format!("{}. {}: {}", place + 1, sums(choice, next), differences(robot, best, next));
            out.push_str(&format!("    {}\n", wrap(&line, 7)));
        }
    }
    if !choice.changes.is_empty() {
        out.push_str("\n  What the budgets cost:\n");
        for change in &choice.changes {
            out.push_str(&format!("    {}\n", wrap(&change_text(choice, best, change), 6)));
        }
    }
    if choice.others_left_out {
        out.push_str("\n  The search took long: what other budgets would give was not looked at.\n");
    }
    if choice.front.len() > 1 {
        out.push_str("\n  Less mass costs (the best for each mass, other budgets kept):\n");
        let value = match unit(choice) {
            "" => format!(">{}", choice.total.name),
            unit => format!(">{} [{unit}]", choice.total.name),
        };
        let rows = choice.front.iter().map(|c| {
            let differ = best.joints.iter().zip(&c.joints).filter(|(a, b)| name(a) != name(b)).count();
            let change = if differ > 2 { format!("{differ} joints differ") } else { differences(robot, best, c) };
            vec![optional(c.mass), number(c.objective), change]
        });
        let rows: Vec<Vec<String>> = rows.collect();
        out.push_str(&indented(&table(&[">mass [kg]", &value, "against the choice"], &rows)));
    }
    out.push_str(&super::unjudged::robot_text(choice));
    out
}

fn indented(text: &str) -> String {
    text.lines().map(|l| format!("    {l}\n")).collect()
}

fn unit(choice: &Choice) -> &'static str {
    if choice.total.unit == "1" { "" } else { choice.total.unit }
}

/// What is minimised over the robot.
fn aim(choice: &Choice) -> String {
    match choice.total.relative {
        true => "least sum of objectives, each over the best that its joint could have alone (they minimise different things)".into(),
        false => format!("least {} summed over all joints", choice.total.name),
    }
}

/// What the combination had to keep, and how power was added up.
fn kept(choice: &Choice) -> String {
    let (robot, mut parts) = (choice.robot, Vec::new());
    if let Some(mass) = robot.budget.actuator_mass {
        parts.push(format!("actuators of at most {} kg", number(mass)));
    }
    if let Some(motors) = robot.budget.max_distinct_motors {
        parts.push(format!("at most {}", different_motors(motors as usize)));
    }
    if let Some(power) = robot.shared_power() {
        let how = match choice.instant_by_instant {
            true => "added up instant by instant".to_string(),
            false => {
                let bases: Vec<String> = choice.time_bases.iter().map(|b| b.join(" + ")).collect();
                format!("a safe bound: the sum of the peaks of {}, which share no time base", bases.join(" and of "))
            }
        };
        parts.push(format!("at most {} W from the bus for all joints together ({how})", number(power)));
        if let Regeneration::Limited(most) = robot.bus.regeneration {
            parts.push(format!(
                "each joint by itself may give back at most {} W, also where another could use more",
                number(most)
            ));
        }
    }
    for joint in &robot.joints {
        if !joint.carries.is_empty() {
            let names: Vec<&str> = joint.carries.iter().map(|c| robot.joints[c.joint].name.as_str()).collect();
            parts.push(format!("{} carries the actuators of {}", joint.name, names.join(", ")));
        }
    }
    if parts.is_empty() {
        return "no budget: each joint's own best is the robot's best".into();
    }
    let alone = "the tables above take each joint by itself";
    format!("{} ({alone})", parts.join("; "))
}

fn name(design: &Design) -> String {
    let gear = design.gear.map_or_else(String::new, |g| format!(" + {g}"));
    format!("{}{gear}", design.motor.id)
}

fn designs(robot: &Robot, best: &Combination) -> String {
    let rows: Vec<Vec<String>> = robot
        .joints
        .iter()
        .zip(&best.joints)
        .map(|(joint, design)| {
            let e = &design.evaluation;
            let mark = if design.unchecked.is_empty() { "" } else { " *" };
            let tightest =
                e.tightest().map_or_else(String::new, |m| format!("{} {:.0} %", m.limit, (100.0 * m.margin).max(0.0)));
            vec![
                joint.name.clone(),
                joint.count.to_string(),
                format!("{}{mark}", name(design)),
                number(e.ratio),
                number(e.loss),
                number(e.reflected_inertia),
                optional(e.mass),
                tightest,
            ]
        })
        .collect();
    let header = ["joint", ">×", "motor", ">N", ">loss [W]", ">J [kg*m^2]", ">mass [kg]", "tightest margin"];
    let mut out: String = table(&header, &rows).lines().map(|l| format!("  {}\n", l.trim_end())).collect();
    if best.joints.iter().any(|d| !d.unchecked.is_empty()) {
        out.push_str("  * not every limit could be checked: the joint's table above says which\n");
    }
    out
}

fn sums(choice: &Choice, combination: &Combination) -> String {
    let mut text = format!("{} {} {}", choice.total.name, number(combination.objective), unit(choice));
    text = text.trim_end().to_string();
    match combination.mass {
        Some(mass) => text.push_str(&format!(", {} kg", number(mass))),
        None => text.push_str(", mass not known"),
    }
    text.push_str(&format!(", {}", different_motors(combination.distinct_motors)));
    let peak = number(combination.peak_power);
    match choice.instant_by_instant {
        true => text.push_str(&format!(", {peak} W at the worst instant")),
        false => text.push_str(&format!(", {peak} W as the sum of peaks")),
    }
    text
}

fn proof(choice: &Choice) -> String {
    let proof = &choice.proof;
    let gap = proof.gap.unwrap_or(f64::INFINITY);
    if proof.certified() {
        let gap = if gap < 1e-12 { "exact".to_string() } else { format!("gap {gap:.0e}") };
        return format!("proved: no combination is better ({gap}, {} branches looked at)", proof.branches);
    }
    let how_far = match gap.is_finite() {
        true => super::may_be_beaten(gap),
        false => "by how much it may be beaten is not known".into(),
    };
    format!("NOT proved, {how_far}: {}", proof.not_proved.join("; "))
}

/// In which joints another combination differs.
fn differences(robot: &Robot, best: &Combination, other: &Combination) -> String {
    let pairs = robot.joints.iter().zip(best.joints.iter().zip(&other.joints));
    let changed = pairs.filter(|(_, (a, b))| name(a) != name(b));
    let list: Vec<String> = changed.map(|(j, (_, b)): (&Joint, _)| format!("{}: {}", j.name, name(b))).collect();
    if list.is_empty() { "the same motors".into() } else { list.join(", ") }
}

fn percent(new: f64, old: f64) -> String {
    if old == 0.0 {
        return format!("{} instead of 0", number(new));
    }
    let change = 100.0 * (new - old) / old.abs();
    if change.abs() < 0.005 { "unchanged".into() } else { format!("{change:+.2} %").replace('-', "−") }
}

fn budget_now(robot: &Robot, budget: &str) -> Option<f64> {
    match budget {
        "actuator_mass" => robot.budget.actuator_mass,
        "max_distinct_motors" => robot.budget.max_distinct_motors.map(f64::from),
        _ => robot.shared_power(),
    }
}

/// The joint question of a budget: what a step more or less of it is worth.
fn change_text(choice: &Choice, best: &Combination, change: &Change) -> String {
    let now = budget_now(choice.robot, change.budget).unwrap_or(f64::NAN);
    let step = change.value - now;
    let word = if step > 0.0 { "more" } else { "less" };
    let unit = change.unit;
    let (size, unit) = if unit == "kg" && step.abs() < 1.0 { (step.abs() * 1e3, "g") } else { (step.abs(), unit) };
    let head = match (change.unit, step > 0.0) {
        ("1", true) => format!("one motor more ({} {})", change.budget, change.value),
        ("1", false) => format!("one motor fewer ({} {})", change.budget, change.value),
        _ => format!("{} {unit} {word} ({} {} {})", number(size), change.budget, number(change.value), change.unit),
    };
    let Some(new) = &change.best else { return format!("{head}: no combination keeps it") };
    let doubt = if change.certified { "" } else { " (not proved)" };
    format!(
        "{head}: {} {}{doubt}; {}",
        choice.total.name,
        percent(new.objective, best.objective),
        differences(choice.robot, best, new)
    )
}

fn wanting_text(choice: &Choice) -> String {
    let proved = match choice.proof.certified() {
        true => "  NO combination keeps all of this.",
        false => "  No combination was found that keeps all of this; that there is none is not proved.",
    };
    let mut out = format!("{proved}\n");
    for wanting in &choice.wanting {
        let line = match wanting {
            Wanting::Joints(names) => match choice.unjudged.is_empty() {
                true => format!("no motor of the catalogue can do: {}", names.join(", ")),
                false => format!("no motor that can be judged can do: {}", names.join(", ")),
            },
            Wanting::Mass(mass) => format!(
                "it can be done with {} kg of actuators, not with less (budget {} kg)",
                number(*mass),
                optional(choice.robot.budget.actuator_mass)
            ),
            Wanting::Motors(motors) => {
                format!("it can be done with {}, not with fewer", different_motors(*motors))
            }
            Wanting::Power(least, draws) => format!(
                "without the limit on power the best draws {} W at its worst; of the combinations tried none can do \
                 with less than {} W (budget {} W)",
                number(*draws),
                number(*least),
                optional(choice.robot.shared_power())
            ),
        };
        out.push_str(&format!("    {}\n", wrap(&line, 6)));
    }
    out
}

fn combination_json(robot: &Robot, combination: &Combination) -> Value {
    let joints = robot.joints.iter().zip(&combination.joints).zip(&combination.carried).map(|((joint, d), carried)| {
        let e = &d.evaluation;
        let of_constant = joint.carries.iter().any(|c| c.constant);
        let mut value = json!({
            "joint": joint.name, "count": joint.count, "motor": d.motor.id, "gear": d.gear, "ratio": e.ratio,
            "objective": d.optimum.objective, "loss_w": e.loss, "reflected_inertia_kgm2": e.reflected_inertia,
            "mass_kg": e.mass, "unchecked": d.unchecked.iter().map(|u| u.0).collect::<Vec<_>>(),
            "tightest": e.tightest().map(|m| json!({ "limit": m.limit, "margin": m.margin })),
            "carried_torque_nm": carried.first().filter(|_| of_constant),
        });
        currents::add(&mut value, d.motor, e);
        value
    });
    json!({
        "joints": joints.collect::<Vec<_>>(),
        "objective": combination.objective,
        "lower_bound": combination.lower_bound,
        "actuator_mass_kg": combination.mass,
        "peak_power_w": combination.peak_power,
        "objective_per_watt": combination.power_price,
        "distinct_motors": combination.distinct_motors,
    })
}

/// For programs.
pub fn json(choice: &Choice) -> Value {
    let robot = choice.robot;
    let proof = &choice.proof;
    let wanting = choice.wanting.iter().map(|w| match w {
        Wanting::Joints(names) => json!({ "joints": names }),
        Wanting::Mass(mass) => json!({ "actuator_mass_kg": mass }),
        Wanting::Motors(motors) => json!({ "max_distinct_motors": motors }),
        Wanting::Power(least, draws) => json!({ "least_power_tried_w": least, "unlimited_power_w": draws }),
    });
    let changes = choice.changes.iter().map(|c| {
        json!({
            "budget": c.budget, "unit": c.unit, "value": c.value, "certified": c.certified,
            "best": c.best.as_ref().map(|b| combination_json(robot, b)),
        })
    });
    json!({
        "satisfied": !choice.combinations.is_empty(),
        "total": { "name": choice.total.name, "unit": choice.total.unit, "relative": choice.total.relative, "scale": choice.total.scale },
        "budget": {
            "actuator_mass_kg": robot.budget.actuator_mass, "max_distinct_motors": robot.budget.max_distinct_motors,
            "power_w": robot.shared_power(),
        },
        "power_is": if choice.instant_by_instant { "largest at any instant" } else { "sum of peaks over time bases" },
        "time_bases": choice.time_bases,
        "certificate": {
            "certified": proof.certified(), "lower_bound": proof.lower_bound, "gap": proof.gap,
            "not_proved": proof.not_proved, "branches": proof.branches,
        },
        "best": choice.combinations.first().map(|c| combination_json(robot, c)),
        "runner_ups": choice.combinations.iter().skip(1).map(|c| combination_json(robot, c)).collect::<Vec<_>>(),
        "wanting": wanting.collect::<Vec<_>>(),
        "other_budgets": changes.collect::<Vec<_>>(),
        "other_budgets_left_out": choice.others_left_out,
        "front": choice.front.iter().map(|c| combination_json(robot, c)).collect::<Vec<_>>(),
        "unjudged": super::unjudged::robot_json(choice),
    })
}
