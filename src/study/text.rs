//! A study as a whole: how often each motor wins, and what each parameter does.

use crate::report::number;
use crate::report::table::{Column, Table, paragraph};
use crate::study::effects::Effect;
use crate::study::summary::{JointSummary, Summary};

/// Motors of a joint that the text lists.
const LISTED: usize = 5;
/// Effects that the text lists.
const EFFECTS: usize = 60;

/// For people.
pub fn text(summary: &Summary) -> String {
    let heading =
        format!("{}, {} could not be worked on, {} rows", robots(summary.robots), summary.broken, summary.rows);
    let mut out = paragraph(&heading, 0, 2);
    for joint in &summary.joints {
        out.push_str(&joint_text(joint, summary.top));
    }
    out.push_str(&effects_text(&summary.effects));
    out
}

/// How many robots.
pub fn robots(count: u64) -> String {
    if count == 1 { "1 robot".into() } else { format!("{count} robots") }
}

fn joint_text(joint: &JointSummary, top: Option<u32>) -> String {
    let mut heading = format!("{}: {}", joint.joint, robots(joint.robots));
    let impossible = joint.without_design - joint.unjudged - joint.without_combination;
    if impossible > 0 {
        heading.push_str(&format!(", in {impossible} of them no motor can do it"));
    }
    if joint.unjudged > 0 {
        heading.push_str(&format!(", in {} of them no motor that can be judged can do it", joint.unjudged));
    }
    if joint.without_combination > 0 {
        let of = format!(", for {} of them no combination of all joints was found", joint.without_combination);
        heading.push_str(&of);
    }
    if let (Some(least), Some(mean), Some(most)) = (joint.least_loss_w, joint.mean_loss_w, joint.largest_loss_w) {
        let [least, mean, most] = [least, mean, most].map(number);
        heading.push_str(&format!("; loss of the first choice {least} to {most} W, mean {mean} W"));
    }
    let mut out = format!("\n{}\n", paragraph(&heading, 0, 2));
    let among = top.map_or_else(|| "can\ndo it".to_string(), |k| format!("among\nfirst {k}"));
    let columns = vec![
        Column::name("motor"),
        Column::number("first\nchoice", ""),
        Column::number("share", ""),
        Column::number(among, ""),
        Column::number("cannot", "").dropped(1),
    ];
    let rows = joint.motors.iter().take(LISTED).map(|m| {
        let share = format!("{} %", number((1000.0 * m.first as f64 / joint.robots as f64).round() / 10.0));
        vec![m.motor.clone(), m.first.to_string(), share, m.among.to_string(), m.cannot.to_string()]
    });
    let table = Table::new(columns).indented(2).also_in("summary.json").rows(rows);
    if !table.is_empty() {
        out.push_str(&table.text());
    }
    if joint.motors.len() > LISTED {
        out.push_str(&format!("  and {} more\n", joint.motors.len() - LISTED));
    }
    out
}

fn effects_text(effects: &[Effect]) -> String {
    if effects.is_empty() {
        return String::new();
    }
    let mut out = String::from("\nWhat the parameters do, all else equal:\n\n");
    let columns = vec![
        Column::name("parameter"),
        Column::name("value"),
        Column::name("against"),
        Column::name("joint"),
        Column::number("loss\ntimes", ""),
        Column::number("other\nfirst choice", "").dropped(4),
        Column::number("gained", "").dropped(3),
        Column::number("lost", "").dropped(2),
        Column::number("pairs", "").dropped(1),
    ];
    let rows = effects.iter().take(EFFECTS).map(|e| {
        let share = |n: u64| {
            if e.pairs == 0 { "–".to_string() } else { format!("{:.0} %", 100.0 * n as f64 / e.pairs as f64) }
        };
        vec![
            e.parameter.clone(),
            e.value.clone(),
            e.reference.clone(),
            e.joint.clone(),
            crate::report::optional(e.loss_ratio),
            share(e.other_first_choice),
            e.gained.to_string(),
            e.lost.to_string(),
            e.pairs.to_string(),
        ]
    });
    out.push_str(&Table::new(columns).indented(2).also_in("summary.json").rows(rows).text());
    if effects.len() > EFFECTS {
        out.push_str(&format!("  and {} more, see summary.json\n", effects.len() - EFFECTS));
    }
    let note = "Loss times: geometric mean over the pairs of points that differ in this parameter alone and have a design at both \
                values. Gained, lost: points that have a design at this value only, or at the other only.";
    out.push_str(&format!("\n{}", paragraph(note, 2, 2)));
    out
}

/// For programs.
pub fn json_text(summary: &Summary) -> String {
    crate::report::json_text(&crate::report::json::document("study", summary))
}
