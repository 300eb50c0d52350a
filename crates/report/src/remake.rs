//! What a measurement changes in the choice of motor and ratio.

use super::number;
use super::optimize::{bind_text, proof};
use super::reason::reason_text;
use super::said::margin_text;
use super::table::{Column, Table, paragraph_at};
use gearwise_model::effects::Shape;
use gearwise_model::requirement::{Joint, RatioChoice};
use gearwise_select::remake::{Choice, Chosen, Part, Regret, Remade, Share};

/// For people.
pub fn text(remade: &[Remade]) -> String {
    text_at(remade, super::table::width())
}

/// [`text`] of a width \[columns\].
pub fn text_at(remade: &[Remade], width: usize) -> String {
    remade.iter().map(|one| joint_text(one, width)).collect()
}

fn columns(joint: &Joint) -> Vec<Column> {
    let ends = if matches!(joint.ratio, RatioChoice::Catalog { .. }) { "gear" } else { "bounded by" };
    vec![
        Column::name(""),
        Column::name("motor"),
        Column::number("N*", ""),
        Column::number("window", "").dropped(2),
        Column::prose(ends).dropped(1),
        Column::number(joint.goal(), joint.objective.unit()),
        Column::number("rank", ""),
        Column::name("proof").dropped(3),
    ]
}

fn joint_text(one: &Remade, width: usize) -> String {
    let joint = one.joint;
    let heading = format!("{}: the choice made again ({})", joint.name, joint.aim());
    let mut out = format!("{}\n", paragraph_at(&heading, 0, 2, width));
    let mut rows = Vec::new();
    if let Some(before) = &one.before {
        rows.push(choice_row("as declared", one, before));
    }
    rows.push(choice_row("as fitted", one, &one.after));
    if let Some(choice) = &one.output_side {
        rows.push(choice_row("friction at the output", one, choice));
    }
    for (what, first) in [("first choice before", &one.first_before), ("first choice now", &one.first_after)] {
        rows.push(match first {
            Some(chosen) => chosen_row(what, joint, chosen, Some(1)),
            None => none_row(what, "–"),
        });
    }
    out.push_str(&Table::new(columns(joint)).indented(2).also_in("`--json`").rows(rows).text_at(width));
    out.push_str(&shares_text(one, width));
    let mut say = |line: String| out.push_str(&paragraph_at(&line, 2, 4, width));
    for (what, choice) in [("as declared", one.before.as_ref()), ("as fitted", Some(&one.after))] {
        match choice.map(|c| &c.outcome) {
            Some(Ok(chosen)) => {
                if let Some(margin) = chosen.tightest() {
                    say(format!("{what}: tightest margin {} {:.0} %", margin.limit, 100.0 * margin.margin.max(0.0)));
                }
            }
            Some(Err(reason)) => say(format!("{what}: {}", reason_text(reason, joint).1)),
            None => {}
        }
    }
    if let Some(regret) = &one.own_regret {
        say(format!("the declared row's ratio, under the fitted model: {}", regret_text(regret, joint)));
    }
    if let Some(regret) = &one.regret {
        say(format!("the first choice before, under the fitted model: {}", regret_text(regret, joint)));
    }
    if let Some(Choice { outcome: Ok(output), .. }) = &one.output_side
        && let Ok(motor) = &one.after.outcome
    {
        say(format!(
            "one ratio cannot separate friction of the motor from friction at the output: N* = {} if it is the motor's, {} if \
             it is the output's",
            number(motor.ratio),
            number(output.ratio)
        ));
    }
    for note in &one.notes {
        say(format!("{}: {}", note.effect, note.how));
    }
    out.push('\n');
    out
}

/// A part of what was fitted, in words.
pub(super) fn part_title(part: &Part) -> String {
    match part {
        Part::Effect(fitted) => match (fitted.effect.shape(), fitted.values.last()) {
            (Shape::Order, Some(order)) => format!("{} of order {}", fitted.effect.title(), number(*order)),
            _ => fitted.effect.title(),
        },
        Part::Friction => "the measured friction".into(),
        Part::Gear => "the gear's numbers".into(),
        Part::Numbers => "the row's numbers".into(),
    }
}

/// What each part of what was fitted moves; nothing where the fitted motor is no choice.
fn shares_text(one: &Remade, width: usize) -> String {
    let (joint, Ok(after)) = (one.joint, &one.after.outcome) else { return String::new() };
    if one.shares.is_empty() {
        return String::new();
    }
    let columns = vec![
        Column::name("without"),
        Column::number("N*", ""),
        Column::number(joint.goal(), joint.objective.unit()),
        Column::number("loss", "W").dropped(1),
        Column::name("smallest margin").dropped(2),
    ];
    let margin = |chosen: &Chosen| chosen.tightest().map_or_else(String::new, margin_text);
    let cells = |what: String, chosen: &Chosen| {
        vec![what, number(chosen.ratio), number(chosen.objective), number(chosen.loss), margin(chosen)]
    };
    let row = |share: &Share| match &share.without {
        Ok(without) => cells(part_title(&share.part), without),
        Err(_) => vec![part_title(&share.part), "none".into(), String::new(), String::new(), String::new()],
    };
    let rows = one.shares.iter().map(row).chain([cells("nothing (as fitted)".into(), after)]);
    let heading = "What each part of what was fitted moves: the fitted motor without it, chosen again. Without the measured friction the row's drag counts. Parts that act together need not add up.";
    let table = Table::new(columns).indented(2).also_in("`--json`").rows(rows);
    format!("{}{}", paragraph_at(heading, 2, 4, width), table.text_at(width))
}

fn choice_row(what: &str, one: &Remade, choice: &Choice) -> Vec<String> {
    match &choice.outcome {
        Ok(chosen) => chosen_row(what, one.joint, chosen, choice.rank),
        Err(_) => none_row(what, &one.motor),
    }
}

fn none_row(what: &str, motor: &str) -> Vec<String> {
    [what, motor, "none", "", "", "", "", ""].map(str::to_string).to_vec()
}

fn chosen_row(what: &str, joint: &Joint, chosen: &Chosen, rank: Option<usize>) -> Vec<String> {
    let binds = match &chosen.gear {
        Some(gear) => gear.clone(),
        None => format!("{}, {}", bind_text(&chosen.binds.0, joint), bind_text(&chosen.binds.1, joint)),
    };
    vec![
        what.into(),
        chosen.motor.clone(),
        number(chosen.ratio),
        format!("{} to {}", number(chosen.window.0), number(chosen.window.1)),
        binds,
        number(chosen.objective),
        rank.map_or_else(String::new, |r| r.to_string()),
        proof(&chosen.certificate),
    ]
}

pub(super) fn regret_text(regret: &Regret, joint: &Joint) -> String {
    if let Some(margin) = &regret.broken {
        return format!("not feasible: {} is {}", margin.limit, super::demand_of(margin));
    }
    match (regret.objective, regret.relative) {
        (Some(objective), Some(relative)) => format!(
            "{} {}, {:.2} % more than the choice made again",
            joint.goal(),
            super::with_unit(objective, joint.objective.unit()),
            100.0 * relative.max(0.0)
        ),
        (Some(objective), None) => {
            format!(
                "{} {}; nothing to compare it with",
                joint.goal(),
                super::with_unit(objective, joint.objective.unit())
            )
        }
        _ => "unknown".into(),
    }
}
