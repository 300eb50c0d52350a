//! Why a first choice, and what is near it: what binds, how the number comes about, gears, the trade of mass and loss.

use super::answer::{binds, checked, is_of_range, own_bound};
use super::said::{margin_at, per_cent, proof, windows_text};
use super::table::{Column, Table, paragraph};
use super::{balance, design_ratio, losses, number, optional, turns};
use crate::design::answer::{Design, JointResult};
use crate::design::buildable::Train;
use crate::design::flatness::Flatness;
use crate::design::nearby::Nearby;
use crate::design::outlook::{FrontDesign, Outlook};
use crate::design::program::Certificate;
use crate::requirement::{Balancing, Joint};
use crate::words::range_inwards;

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
        let what = match joint.ratio.is_list() {
            true => format!("list {} ratio", key.0),
            false => format!("give `ratio` {} `{}`", key.0, key.1),
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
        out.push_str(&gears(nearby, joint));
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

/// Teeth of a train of simple planetary stages.
pub(super) fn teeth(train: &Train) -> String {
    let stages: Vec<String> =
        train.stages.iter().map(|stage| format!("sun {} ring {}", stage.sun, stage.ring)).collect();
    stages.join(", then ")
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
        teeth(built.train.as_ref()?),
        number(there.ratio),
        number(there.loss),
        optional(there.mass),
        joint.goal(),
        change(nearby.planetary_above(design))
    ))
}

fn gears(nearby: &Nearby, joint: &Joint) -> String {
    if nearby.gears.is_empty() {
        let line = match (&nearby.exceeded, nearby.looked_at) {
            (_, 0) => "no gear of the catalogue near this ratio says what torque it carries and fits".to_string(),
            (Some((gear, margin)), n) => {
                let over = match margin.bound == 0.0 {
                    true => "more than nothing".into(),
                    false => format!("{} times the limit", number(margin.demand / margin.bound)),
                };
                let all = crate::words::counted(n, "gear");
                format!(
                    "of {all} of the catalogue near this ratio none will do: with {}, the nearest, {} is {over}",
                    gear.id, margin.limit
                )
            }
            (None, n) => {
                format!("of {} of the catalogue near this ratio none can be judged", crate::words::counted(n, "gear"))
            }
        };
        return paragraph(&line, 4, 6);
    }
    let columns = vec![
        Column::name("gear of the\ncatalogue"),
        Column::number("N", ""),
        Column::number("mass", "kg"),
        Column::number("loss", "W"),
        Column::number(joint.goal(), "").dropped(2),
        Column::name("against\nthe best"),
    ];
    let rows = nearby.gears.iter().map(|near| {
        let e = &near.evaluation;
        let cells = [number(e.ratio), optional(e.mass), number(e.loss), number(near.objective), change(near.above)];
        std::iter::once(near.gear.id.clone()).chain(cells).collect()
    });
    let unit = joint.objective.unit();
    let mut columns = columns;
    columns[4] = Column::number(joint.goal(), unit).dropped(2);
    format!("\n{}", Table::new(columns).indented(4).also_in("`--json`").rows(rows).text())
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
