//! The choice for a whole robot: which design at which joint, what it keeps, how sure it is, what comes next
//! and what the budgets cost.

use std::time::Duration;

use super::optimize::margin_at;
use super::table::{Column, Table, paragraph, wrap};
use super::{columns, design_ratio, different_motors, number, optional};
use gearwise_model::requirement::{Joint, Quantity, Regeneration, Robot};
use gearwise_select::answer::Design;
use gearwise_select::robot::{Bill, Change, Choice, Combination, Sag, Wanting};

/// That joules per cycle are summed of cycles that do not last the same.
fn cycles_differ(robot: &Robot) -> Option<String> {
    let of_energy = robot.joints.iter().filter(|j| j.objective.weight(Quantity::Energy) > 0.0);
    let lasts: Vec<f64> = of_energy.filter_map(|j| j.motion.duration()).collect();
    let least = lasts.iter().copied().fold(f64::INFINITY, f64::min);
    let most = lasts.iter().copied().fold(0.0, f64::max);
    (most > least * (1.0 + 1e-9)).then(|| {
        format!(
            "cycles last from {} s to {} s: the sum is of joules per cycle of each joint, which is no energy of one time; \
             `loss`, or motions that repeat together, weigh joints by time",
            number(least),
            number(most)
        )
    })
}

/// For people; `took` is how long the search took, where it was given a time.
pub fn text(choice: &Choice, took: Option<Duration>) -> String {
    let robot = choice.robot;
    let mut out = paragraph(&format!("The whole robot, {}:", aim(choice)), 0, 2);
    out.push_str(&paragraph(&kept(choice), 2, 4));
    if let Some(line) = cycles_differ(robot) {
        out.push_str(&paragraph(&line, 2, 4));
    }
    let Some(best) = choice.combinations.first() else {
        out.push_str(&wanting_text(choice));
        open(choice, took).iter().for_each(|line| out.push_str(&format!("    {}\n", wrap(line, 6))));
        out.push_str(&super::unjudged::robot_text(choice));
        return out;
    };
    out.push('\n');
    out.push_str(&designs(robot, best));
    out.push_str(&format!("\n  {}\n", wrap(&sums(choice, best), 4)));
    if let Some(sag) = &best.sag {
        out.push_str(&format!("  {}\n", wrap(&sag_text(robot, sag), 4)));
    }
    out.push_str(&format!("  {}\n", wrap(&proof(choice), 4)));
    open(choice, took).iter().for_each(|line| out.push_str(&format!("  {}\n", wrap(line, 4))));
    if let Some(price) = best.power_price.filter(|p| *p < 0.0) {
        let line = format!("the bus binds: one watt more is worth {} {}", number(-price), unit(choice));
        out.push_str(&format!("  {}\n", wrap(line.trim_end(), 4)));
    }
    if let Some(line) = per_mass(choice, best) {
        out.push_str(&format!("  {}\n", wrap(&line, 4)));
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
        for line in change_lines(choice, best) {
            out.push_str(&format!("    {}\n", wrap(&line, 6)));
        }
    }
    if choice.others_left_out {
        let line = "Not all other budgets were looked at: that would take long.";
        out.push_str(&format!("\n{}", paragraph(line, 2, 4)));
    }
    if choice.front.len() > 1 {
        out.push_str(&format!(
            "\n{}",
            paragraph("Less mass costs (the best for each mass, other budgets kept):", 2, 4)
        ));
        let columns = vec![
            Column::number("mass", "kg"),
            Column::number(&*choice.total.name, unit(choice)),
            Column::prose("against the choice"),
        ];
        let rows = choice.front.iter().map(|c| {
            let differ = best.joints.iter().zip(&c.joints).filter(|(a, b)| name(a) != name(b)).count();
            let change = if differ > 2 { format!("{differ} joints differ") } else { differences(robot, best, c) };
            vec![optional(c.mass), number(c.objective), change]
        });
        out.push_str(&Table::new(columns).indented(4).rows(rows).text());
    }
    out.push_str(&super::unjudged::robot_text(choice));
    out
}

pub(super) fn unit(choice: &Choice) -> &'static str {
    if choice.total.unit == "1" { "" } else { choice.total.unit }
}

/// What is minimised over the robot.
pub(super) fn aim(choice: &Choice) -> String {
    match choice.total.relative {
        true => "least sum of objectives, each over the best that its joint could have alone (they minimise different things)".into(),
        false => format!("least {} summed over all joints", choice.total.name),
    }
}

/// What the combination had to keep, and how power was added up.
pub(super) fn kept(choice: &Choice) -> String {
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
                number(most + robot.bus.brake_power.unwrap_or(0.0))
            ));
        }
    }
    if let Some(most) = robot.shared_regeneration() {
        let how = match choice.instant_by_instant {
            true => "added up instant by instant, less what others draw then",
            false => "less what others draw; what shares no time base at its worst instants",
        };
        parts.push(format!("at most {} W back to the bus from all joints together ({how})", number(most)));
    }
    if let Some(resistance) = robot.shared_resistance() {
        let how = match choice.instant_by_instant {
            true => "instant by instant",
            false => "what shares no time base at its worst instants",
        };
        parts.push(format!(
            "a supply of {} ohm that sags under all joints together ({how}; what some give back is not counted on)",
            number(resistance)
        ));
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

pub(super) fn name(design: &Design) -> String {
    let gear = design.gear.filter(|_| design.motor.inside.is_none());
    format!("{}{}", design.motor.id, gear.map_or_else(String::new, |g| format!(" + {g}")))
}

fn designs(robot: &Robot, best: &Combination) -> String {
    let rows = robot.joints.iter().zip(&best.joints).map(|(joint, design)| {
        let facts = design.facts();
        let mark = if design.unchecked.is_empty() { "" } else { " *" };
        let tightest = facts.evaluation.tightest().map_or_else(String::new, |m| margin_at(m, joint));
        let mut row = vec![joint.name.clone(), joint.count.to_string(), format!("{}{mark}", name(design))];
        row.push(design_ratio(design));
        row.extend(columns::in_tables().map(|figure| columns::cell(figure, &facts)));
        row.push(tightest);
        row
    });
    let mut headings = vec![Column::name("joint"), Column::number("×", ""), Column::name("motor")];
    headings.push(Column::number("N", ""));
    headings.extend(columns::in_tables().map(|figure| columns::heading(figure, "")));
    headings.push(Column::name("tightest\nmargin").dropped(6));
    let mut out = Table::new(headings).indented(2).also_in("`--json`").rows(rows).text();
    if best.joints.iter().any(|d| !d.unchecked.is_empty()) {
        let line = "* not every limit could be checked: the joint's table above says which";
        out.push_str(&paragraph(line, 2, 4));
    }
    out
}

pub(super) fn sums(choice: &Choice, combination: &Combination) -> String {
    let mut text = format!("{} {} {}", choice.total.name, number(combination.objective), unit(choice));
    text = text.trim_end().to_string();
    match combination.mass {
        Some(mass) => text.push_str(&format!(", {} kg", number(mass))),
        None => text.push_str(", mass not known"),
    }
    if let Some(bill) = combination.bill(choice.robot) {
        text.push_str(&format!(", {}", bill_text(&bill)));
    }
    text.push_str(&format!(", {}", different_motors(combination.distinct_motors)));
    let peak = number(combination.peak_power);
    match choice.instant_by_instant {
        true => text.push_str(&format!(", {peak} W at the worst instant")),
        false => text.push_str(&format!(", {peak} W as the sum of peaks")),
    }
    if choice.robot.budget.regeneration.is_some() {
        text.push_str(&match combination.most_returned > 0.0 {
            true => format!(", at most {} W back to the bus", number(combination.most_returned)),
            false => ", nothing back to the bus".to_string(),
        });
    }
    if !combination.peak_power_by_case.is_empty() {
        let cases = combination.peak_power_by_case.iter().map(|(name, power)| format!("{name} {} W", number(*power)));
        text.push_str(&format!(" ({})", cases.collect::<Vec<_>>().join(", ")));
    }
    text
}

/// What all actuators cost together, as far as it is known.
fn bill_text(bill: &Bill) -> String {
    let Bill { currency, at_least, known, of } = bill;
    match bill.total() {
        Some(total) => format!("{} {currency}", number(total)),
        None if *at_least > 0.0 => {
            format!("at least {} {currency} (the price of {known} of {of} actuators is known)", number(*at_least))
        }
        None => "price not known".into(),
    }
}

/// What a kilogram more of an actuator costs those that carry it; `None` where none is carried.
pub(super) fn per_mass(choice: &Choice, best: &Combination) -> Option<String> {
    let joints = choice.robot.joints.iter().zip(&best.per_mass);
    let mut priced: Vec<(&str, f64)> = joints.map(|(joint, price)| (joint.name.as_str(), *price)).collect();
    priced.retain(|(_, price)| *price != 0.0);
    priced.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    let one =
        |(name, price): &(&str, f64)| format!("{name} {} {}", number(*price), unit(choice)).trim_end().to_string();
    let all: Vec<String> = priced.iter().map(one).collect();
    (!all.is_empty()).then(|| {
        format!("one kilogram more of an actuator costs, with the same motors at their best ratios: {}", all.join(", "))
    })
}

/// How far all joints together let the bus sag.
pub(super) fn sag_text(robot: &Robot, sag: &Sag) -> String {
    let bus = match sag.lowest {
        Some(lowest) => format!("the bus falls to {} V", number(lowest)),
        None => "the supply cannot give what all joints take".into(),
    };
    let joint = &robot.joints[sag.joint].name;
    let share = number(100.0 * sag.left.abs());
    // Ratios are found to so much of the voltage.
    match sag.left {
        left if left.abs() < 1e-6 => format!("{bus}; of what {joint} needs then nothing is left over: it binds"),
        left if left < 0.0 => format!("{bus}; {joint} is short of {share} % of the supply's voltage"),
        _ => format!("{bus}; {joint}, which has least to spare, has {share} % of the supply's voltage to spare"),
    }
}

pub(super) fn proof(choice: &Choice) -> String {
    let proof = &choice.proof;
    let gap = proof.gap.unwrap_or(f64::INFINITY);
    if proof.certified() {
        let gap = if gap < 1e-12 { "exact".to_string() } else { format!("gap {gap:.0e}") };
        let branches = if proof.branches == 1 { "1 branch".into() } else { format!("{} branches", proof.branches) };
        return format!("proved: no combination is better ({gap}, {branches} looked at)");
    }
    let how_far = match gap.is_finite() {
        true => super::may_be_beaten(gap),
        false => "by how much it may be beaten is not known".into(),
    };
    format!("NOT proved, {how_far}: {}", proof.not_proved.join("; "))
}

/// Motors of a joint that are named where they may be better.
const NAMED: usize = 4;

/// Where the search did not end: what may be better, and how long it would take to know.
pub(super) fn open(choice: &Choice, took: Option<Duration>) -> Vec<String> {
    let proof = &choice.proof;
    if proof.open.is_empty() {
        return Vec::new();
    }
    let mut lines = Vec::new();
    let of_joint = |(joint, motors): (&Joint, &Vec<String>)| {
        let named: Vec<&str> = motors.iter().take(NAMED).map(String::as_str).collect();
        let more = match motors.len().saturating_sub(NAMED) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        (!motors.is_empty()).then(|| format!("{} with {}{more}", joint.name, named.join(", ")))
    };
    let open: Vec<String> = choice.robot.joints.iter().zip(&proof.open).filter_map(of_joint).collect();
    lines.push(match (open.is_empty(), choice.combinations.is_empty()) {
        (true, _) => "every other motor is ruled out; the ratios of these may be better".to_string(),
        (false, true) => format!("not ruled out: {}", open.join("; ")),
        (false, false) => format!("may be better: {}", open.join("; ")),
    });
    let (settled, left) = proof.regions;
    lines.push(match took.map(|took| took.as_secs_f64()) {
        None => "the search ends after a fixed number of steps; with `--time-limit` it goes on for that long".to_string(),
        Some(seconds) if settled > 0 && left > 0 => format!(
            "parts of all combinations: {settled} settled, {left} left; as fast as so far that is {} s more, if none of \
             them has to be divided again",
            number(seconds * left as f64 / settled as f64)
        ),
        Some(_) => "how long more it would take is not known".to_string(),
    });
    lines
}

/// In which joints another combination differs.
pub(super) fn differences(robot: &Robot, best: &Combination, other: &Combination) -> String {
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
        "regeneration" => robot.shared_regeneration(),
        _ => robot.shared_power(),
    }
}

/// What other budgets would change; of a budget near which nothing changes that alone.
pub(super) fn change_lines(choice: &Choice, best: &Combination) -> Vec<String> {
    let is_same = |change: &Change| {
        let same = |a: &Combination, b: &Combination| a.objective == b.objective && a.mass == b.mass;
        change.certified && change.best.as_ref().is_some_and(|new| same(new, best))
    };
    let of = |changes: &[Change]| match changes.iter().all(is_same) {
        true => {
            let values: Vec<String> =
                changes.iter().map(|c| gearwise_model::words::with_unit(c.value, c.unit)).collect();
            vec![format!("{}: with {} the best is the same", changes[0].budget, values.join(" or "))]
        }
        false => changes.iter().map(|change| change_text(choice, best, change)).collect(),
    };
    choice.changes.chunk_by(|a, b| a.budget == b.budget).flat_map(of).collect()
}

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
    let mut out = paragraph(no_combination(choice), 2, 4);
    for line in wanting_lines(choice) {
        out.push_str(&format!("    {}\n", wrap(&line, 6)));
    }
    out
}

/// That there is no combination, as sure as it is.
pub fn no_combination(choice: &Choice) -> &'static str {
    match choice.proof.certified() {
        true => "NO combination keeps all of this.",
        false => "No combination was found that keeps all of this; that there is none is not proved.",
    }
}

/// What would have to be given for there to be one, each by itself.
pub fn wanting_lines(choice: &Choice) -> Vec<String> {
    let budget = &choice.robot.budget;
    let power = choice.robot.shared_power().or(choice.robot.shared_regeneration()).is_some();
    // What is said of one budget holds with the others, and of the motors that can be judged.
    let with = |others: bool| match (others, choice.unjudged.is_empty()) {
        (false, true) => "",
        (true, true) => "with the other budgets kept, ",
        (false, false) => "with motors that can be judged, ",
        (true, false) => "with the other budgets kept and motors that can be judged, ",
    };
    let line = |wanting: &Wanting| match wanting {
        Wanting::Joints(names) => match choice.unjudged.is_empty() {
            true => format!("no motor of the catalogue can do: {}", names.join(", ")),
            false => format!("no motor that can be judged can do: {}", names.join(", ")),
        },
        Wanting::Mass(mass) => format!(
            "{}it can be done with {} kg of actuators, not with less (budget {} kg)",
            with(budget.max_distinct_motors.is_some() || power),
            number(*mass),
            optional(choice.robot.budget.actuator_mass)
        ),
        Wanting::Motors(motors) => {
            let with = with(budget.actuator_mass.is_some() || power);
            format!("{with}it can be done with {}, not with fewer", different_motors(*motors))
        }
        Wanting::Power(least, draws) => format!(
            "without the limit on power there is one, which draws {} W at its worst; of the combinations tried none can do \
             with less than {} W (budget {} W)",
            number(*draws),
            number(*least),
            optional(choice.robot.shared_power())
        ),
        Wanting::Returned(returned) => format!(
            "without the limit on what comes back there is one, which gives back {} W to the bus at its worst (it may be {} W)",
            number(*returned),
            optional(choice.robot.shared_regeneration())
        ),
        Wanting::NotSettled => "whether it can be done with another budget was not settled".to_string(),
        Wanting::Supply => format!(
            "with a supply that does not sag it can be done: its resistance is {} ohm",
            optional(choice.robot.shared_resistance())
        ),
    };
    if choice.wanting.is_empty() && !choice.proof.certified() {
        return Vec::new();
    }
    if choice.wanting.is_empty() {
        let budget = &choice.robot.budget;
        let has_budget = budget.actuator_mass.is_some() || budget.max_distinct_motors.is_some() || power;
        return vec![match has_budget {
            true => "with any one of the budgets given up none was found either".into(),
            false => "no budget is stated: with what they carry, joints exceed limits of their own".to_string(),
        }];
    }
    choice.wanting.iter().map(line).collect()
}
