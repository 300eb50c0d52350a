//! Why a first choice, and what is near it: what binds, how the number comes about, gears, the trade of mass and loss.

use super::answer::{binds, checked, is_of_range, own_bound};
use super::said::{margin_at, per_cent, proof, windows_text};
use super::table::{Column, Table, paragraph};
use super::{balance, demand_of, design_ratio, losses, number, optional, teeth, turns};
use gearwise_model::actuator::limits::Remark;
use gearwise_model::catalog::Gear;
use gearwise_model::requirement::{Balancing, Joint, Quantity};
use gearwise_model::words::range_inwards;
use gearwise_select::answer::{Design, JointResult};
use gearwise_select::flatness::Flatness;
use gearwise_select::nearby::{Gap, NearGear, Nearby, Parts, Standing};
use gearwise_select::outlook::{FrontDesign, Outlook};
use gearwise_select::program::Certificate;

/// Why the first choice of a joint; empty where there is none.
pub(super) fn text(result: &JointResult, outlook: Option<&Outlook>) -> String {
    let (Some(design), Some(outlook)) = (result.candidates.first(), outlook) else { return String::new() };
    let joint = result.joint;
    let mut out =
        format!("\n{}", paragraph(&format!("Why {} at N = {}:", design.motor.id, design_ratio(design)), 2, 4));
    let mut say = |line: &str| out.push_str(&paragraph(line, 4, 6));
    let [what, sure] = how(design, joint);
    say(&what);
    say(&sure);
    if let Some(line) = super::said::gear_of_ratio(joint, design.optimum.ratio) {
        say(&line);
    }
    say(&losses::sentence(&design.evaluation));
    losses::of_supply(&design.evaluation).iter().for_each(|line| say(line));
    losses::of_gear(&design.evaluation).iter().for_each(|line| say(line));
    if let Some(found) = outlook.break_even(design.motor) {
        say(&losses::break_even(found, design.motor));
    }
    if let Some(found) = &outlook.open_order {
        say(&losses::open_order(found, design.motor));
    }
    if let Balancing::Made(balance) = &joint.balancing {
        say(&balance::sentence(balance));
    }
    if let Some(bound) = &outlook.own_bound {
        let key = if bound.is_largest { ("a larger", "max") } else { ("a smaller", "min") };
        let what = match (joint.ratio.is_list(), joint.ratio.teeth().is_some()) {
            (true, _) => format!("list {} ratio", key.0),
            (_, true) => format!("allow {} ratio of a stage", key.0),
            _ => format!("give `ratio` {} `{}`", key.0, key.1),
        };
        let kept = if design.unchecked.is_empty() { "every limit" } else { "every checked limit" };
        say(&format!("{}; {kept} is kept there: {what}, if it can be built", own_bound(bound, joint)));
    }
    if let Some(flat) = &outlook.flatness {
        say(&flatness(flat, joint, design));
    }
    let rewound = outlook.rewound.as_ref();
    if let Some(line) = rewound.and_then(|how| turns::first(how, design.motor, design.optimum.objective)) {
        say(&line);
    }
    design.unchecked.iter().for_each(|(what, why)| say(&format!("not checked: {what}: {why}")));
    design.assumed.iter().for_each(|(what, holds)| say(&format!("assumed: {what}: {holds}")));
    if let Some(line) = checked(result) {
        say(&line);
    }
    if let Some(line) = runner_up(result, design) {
        say(&line);
    }
    if let Some(nearby) = &outlook.nearby {
        if let Some(line) = planetary(nearby, design, joint) {
            say(&line);
        }
        out.push_str(&gears(nearby, design, joint));
    }
    out + &front(&outlook.front)
}

/// What binds and where else the ratio may be; what a limit is worth, and how sure the ratio is.
fn how(design: &Design, joint: &Joint) -> [String; 2] {
    let margin = design.evaluation.tightest();
    let margin = margin.map_or_else(String::new, |m| format!("; smallest margin {}", margin_at(m, joint)));
    let windows = windows_text(&design.optimum, joint).filter(|_| design.gear.is_none());
    let feasible = windows.map_or_else(String::new, |windows| format!("; feasible from {windows}"));
    let prices: Vec<String> = design
        .optimum
        .shadow_prices
        .iter()
        // The ends of a list are no limits that move.
        .filter(|p| joint.ratio.listed().is_none() || !is_of_range(p.limit))
        .map(|p| format!("1 % more of {} changes the objective by {} %", p.limit, signed(p.elasticity)))
        .collect();
    let prices = if prices.is_empty() { String::new() } else { format!("; {}", prices.join(", ")) };
    let sure = match &design.optimum.certificate {
        Certificate::Certified { method, .. } => {
            format!("proved: {} ({method})", proof(&design.optimum.certificate))
        }
        Certificate::NotCertified(why) => format!("not certified: {why}"),
    };
    let unit = match joint.objective.unit() {
        "1" => String::new(),
        unit => format!(" {unit}"),
    };
    [
        format!("{}{margin}{feasible}", binds(design, joint)),
        format!("{} = {}{unit}, {sure}{prices}", joint.goal(), number(design.optimum.objective)),
    ]
}

/// The ratios that are nearly as good, rounded inwards.
pub(super) fn flatness(flat: &Flatness, joint: &Joint, design: &Design) -> String {
    let [from, to] = range_inwards(flat.from, flat.to);
    let spring = if design.spring.is_some() { ", with this spring" } else { "" };
    let sure = if flat.proved { "" } else { "; evaluated, not proved" };
    let kept = if design.unchecked.is_empty() { "all limits" } else { "all checked limits" };
    format!(
        "{} within {} of its least from N = {from} to {to}, {kept} kept{spring}{sure}",
        joint.goal(),
        per_cent(flat.within)
    )
}

/// The next design.
fn runner_up(result: &JointResult, design: &Design) -> Option<String> {
    let next = result.candidates.get(1)?;
    let gear = next.gear.map_or_else(String::new, |gear| format!(" with {gear}"));
    let above = (design.optimum.objective > 0.0).then(|| next.optimum.objective / design.optimum.objective - 1.0);
    let above = above.map_or_else(String::new, |share| format!(": {} more of the objective", per_cent(share)));
    Some(format!("next: {}{gear} at N = {}{above}", next.motor.id, design_ratio(next)))
}

/// A number with two decimals and its sign.
fn signed(value: f64) -> String {
    let sign = if value < 0.0 { "−" } else { "+" };
    format!("{sign}{:.2}", value.abs())
}

/// What is more or less of the objective, with its sign.
fn change(above: Option<f64>) -> String {
    above.map_or_else(
        || "–".into(),
        |share| match (1000.0 * share).round() / 10.0 {
            0.0 => "0 %".into(),
            more if more > 0.0 => format!("+{} %", number(more)),
            less => format!("−{} %", number(-less)),
        },
    )
}

fn planetary(nearby: &Nearby, design: &Design, joint: &Joint) -> Option<String> {
    let built = nearby.planetary.as_ref()?;
    let there = &built.design.evaluation;
    Some(format!(
        "simple planetary near by: {} teeth, N = {}: loss {} W, {} kg, {} {}",
        teeth::of_train(built.train.as_ref()?),
        number(there.ratio),
        number(there.loss),
        optional(there.mass),
        joint.goal(),
        change(nearby.planetary_above(design))
    ))
}

fn gears(nearby: &Nearby, design: &Design, joint: &Joint) -> String {
    if let Some(gap) = &nearby.gap {
        return paragraph(&no_gear(gap), 4, 6);
    }
    let mut out = paragraph(&format!("{}:", heading(nearby)), 4, 6);
    nearby.gears.iter().for_each(|near| out.push_str(&paragraph(&near_gear(near, design, joint), 6, 8)));
    out
}

/// How many gears are near by and named, and whether one of them will do.
pub(super) fn heading(nearby: &Nearby) -> String {
    let named = nearby.gears.len();
    // The best are named first: what the first does not keep none does.
    let keeps = nearby.gears.first().is_some_and(|near| near.standing == Standing::Keeps);
    match (nearby.looked_at > named, keeps) {
        (false, true) => "gears of the catalogue near by".into(),
        (true, true) => format!("gears of the catalogue near by, the first {named} of {}", nearby.looked_at),
        (false, false) => "gears of the catalogue near by, none of which is known to keep every limit".into(),
        (true, false) => format!(
            "gears of the catalogue near by: none of {} is known to keep every limit; the first {named}",
            nearby.looked_at
        ),
    }
}

/// Between which ratios the catalogue has no gear that will do.
pub(super) fn no_gear(gap: &Gap) -> String {
    let named = |gear: &Gear| format!("{}:1 ({})", number(gear.ratio), gear.id);
    let of = "and fits this motor and the requirement's ratios";
    match (gap.below, gap.above) {
        (Some(below), Some(above)) => {
            format!("no gear of the catalogue is between {} and {} {of}", named(below), named(above))
        }
        (None, Some(above)) => format!("no gear of the catalogue is below {} {of}", named(above)),
        (Some(below), None) => format!("no gear of the catalogue is above {} {of}", named(below)),
        (None, None) => "no gear of the catalogue fits this motor and the requirement's ratios".into(),
    }
}

/// A gear near by: what it costs, where that comes from, and how far it keeps the limits.
fn near_gear(near: &NearGear, design: &Design, joint: &Joint) -> String {
    let [cost, mass, kept] = near_gear_cells(near, design, joint);
    let said: Vec<String> = [cost, mass].into_iter().filter(|text| !text.is_empty()).collect();
    let said = if said.is_empty() { String::new() } else { format!("{}; ", said.join(", ")) };
    format!("{}:1 {}: {said}{kept}", number(near.gear.ratio), near.gear.id)
}

/// What a gear near by costs more of the objective, what of mass, and how far it keeps the limits; the first two empty where
/// nothing can be evaluated.
pub(super) fn near_gear_cells(near: &NearGear, design: &Design, joint: &Joint) -> [String; 3] {
    let kept = standing(near, design);
    let Some(there) = &near.evaluation else { return [String::new(), String::new(), kept] };
    let mass_alone = joint.objective.sole() == Some(Quantity::Mass);
    let cost = match near.more {
        _ if mass_alone => String::new(),
        None => format!("{} not known", joint.goal()),
        Some(more) => {
            let parts = near.parts.map_or_else(String::new, |parts| parts_text(&parts, near, design, joint));
            format!("{} {}{parts}", joint.goal(), more_of(more, design, joint, true))
        }
    };
    let mass = match near.mass {
        Some(more) => format!("mass {} kg", with_sign(more)),
        None if there.mass.is_none() => "mass not known".into(),
        None => "mass not compared: that of the best design is not known".into(),
    };
    [cost, mass, kept]
}

/// Where what a gear costs more comes from.
fn parts_text(parts: &Parts, near: &NearGear, design: &Design, joint: &Joint) -> String {
    let one = |name: &str, more: f64| format!("{name} {}", more_of(more, design, joint, false));
    let inertia = match parts.inertia {
        Some(more) => one("inertia", more),
        None if near.gear.inertia.is_none() => "inertia not known, left out".into(),
        None => String::new(),
    };
    let mass = parts.mass.map(|more| one("mass", more));
    let all = [one("ratio", parts.ratio), one("efficiency", parts.efficiency), inertia];
    let all: Vec<String> = all.into_iter().chain(mass).filter(|text| !text.is_empty()).collect();
    format!(" ({})", all.join(", "))
}

/// More or less of the objective: as a share of the best where that means something.
fn more_of(more: f64, design: &Design, joint: &Joint, with_unit: bool) -> String {
    let best = design.optimum.objective;
    match (best > 0.0, joint.objective.unit()) {
        (true, _) => {
            let share = with_sign((1000.0 * more / best).round() / 10.0);
            if with_unit { format!("{share} %") } else { share }
        }
        (false, unit) if with_unit && unit != "1" => format!("{} {unit}", with_sign(more)),
        (false, _) => with_sign(more),
    }
}

/// A number with its sign.
fn with_sign(value: f64) -> String {
    match number(value.abs()).as_str() {
        "0" => "0".into(),
        size if value > 0.0 => format!("+{size}"),
        size => format!("−{size}"),
    }
}

/// How far a gear keeps the limits, and what of them cannot be judged with it.
fn standing(near: &NearGear, design: &Design) -> String {
    let remarks = |all: Vec<&Remark>| {
        let all: Vec<String> = all.iter().map(|(name, why)| format!("{name} ({why})")).collect();
        all.join(", ")
    };
    let is_new = |remark: &&Remark| !design.unchecked.contains(remark);
    match &near.standing {
        Standing::Keeps if near.keeps_all() => "all limits kept".into(),
        Standing::Keeps => "all checked limits kept".into(),
        Standing::LessKnown | Standing::Unjudged => {
            let new: Vec<&Remark> = near.unchecked.iter().filter(is_new).collect();
            let what = match near.standing {
                Standing::Unjudged => "all checked limits kept, but it cannot be judged",
                _ => "all checked limits kept; not checked with it",
            };
            match new.is_empty() {
                true => "all checked limits kept".into(),
                false => format!("{what}: {}", remarks(new)),
            }
        }
        Standing::Exceeds => {
            let over = near.exceeded();
            let worst = over.first().map_or_else(String::new, |m| format!("exceeds {} ({})", m.limit, demand_of(m)));
            let others: Vec<&str> = over.iter().skip(1).map(|m| m.limit).collect();
            if others.is_empty() { worst } else { format!("{worst} and {}", others.join(", ")) }
        }
        Standing::Unusable(why) => format!("cannot be evaluated: {}", why.reason()),
    }
}

fn front(front: &[FrontDesign]) -> String {
    if front.len() < 2 {
        return String::new();
    }
    let columns = vec![
        Column::name("from the lightest\nto the least loss"),
        Column::name("motor"),
        Column::number("N", ""),
        Column::number("mass", "kg"),
        Column::number("loss", "W"),
        Column::name("proof").dropped(1),
    ];
    let mut table = Table::new(columns).indented(4).also_in("`--json`");
    for FrontDesign { share, design } in front {
        let name = match share {
            0.0 => "lightest".to_string(),
            0.5 => "balanced".into(),
            1.0 => "least loss".into(),
            share => format!("loss counts {} %", number(100.0 * share)),
        };
        let e = &design.evaluation;
        let cells = [name, design.motor.id.clone(), design_ratio(design), optional(e.mass), number(e.loss)];
        let cells = cells.into_iter().chain([proof(&design.optimum.certificate)]).collect();
        table.push(cells, design.gear.iter().map(|gear| format!("with {gear}")).collect());
    }
    format!("\n{}", table.text())
}
