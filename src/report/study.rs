//! A study as a whole: how often each motor wins, and what each parameter does.

use super::number;
use super::table::{table, wrap};
use crate::study::effects::Effect;
use crate::study::summary::{JointSummary, Summary};

/// Motors of a joint that the text lists.
const LISTED: usize = 5;
/// Effects that the text lists.
const EFFECTS: usize = 60;

/// For people.
pub fn text(summary: &Summary) -> String {
    let mut out =
        format!("{}, {} could not be worked on, {} rows\n", robots(summary.robots), summary.broken, summary.rows);
    for joint in &summary.joints {
        out.push_str(&joint_text(joint, summary.top));
    }
    out.push_str(&effects_text(&summary.effects));
    out
}

fn robots(count: u64) -> String {
    if count == 1 { "1 robot".into() } else { format!("{count} robots") }
}

fn joint_text(joint: &JointSummary, top: Option<u32>) -> String {
    let mut out = format!("\n{}: {}", joint.joint, robots(joint.robots));
    let impossible = joint.without_design - joint.unjudged;
    if impossible > 0 {
        out.push_str(&format!(", in {impossible} of them no motor can do it"));
    }
    if joint.unjudged > 0 {
        out.push_str(&format!(", in {} of them no motor that can be judged can do it", joint.unjudged));
    }
    if let (Some(least), Some(mean), Some(most)) = (joint.least_loss_w, joint.mean_loss_w, joint.largest_loss_w) {
        let [least, mean, most] = [least, mean, most].map(number);
        out.push_str(&format!("; loss of the first choice {least} to {most} W, mean {mean} W"));
    }
    out.push_str("\n\n");
    let among = top.map_or_else(|| ">can do it".to_string(), |k| format!(">among first {k}"));
    let header = ["motor", ">first choice", ">share", among.as_str(), ">cannot"];
    let rows: Vec<Vec<String>> = joint
        .motors
        .iter()
        .take(LISTED)
        .map(|m| {
            let share = format!("{} %", number((1000.0 * m.first as f64 / joint.robots as f64).round() / 10.0));
            vec![m.motor.clone(), m.first.to_string(), share, m.among.to_string(), m.cannot.to_string()]
        })
        .collect();
    if !rows.is_empty() {
        for line in table(&header, &rows).lines() {
            out.push_str(&format!("  {line}\n"));
        }
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
    let header =
        ["parameter", "value", "against", "joint", ">loss times", ">other first choice", ">gained", ">lost", ">pairs"];
    let rows: Vec<Vec<String>> = effects
        .iter()
        .take(EFFECTS)
        .map(|e| {
            let share = |n: u64| {
                if e.pairs == 0 { "–".to_string() } else { format!("{:.0} %", 100.0 * n as f64 / e.pairs as f64) }
            };
            vec![
                e.parameter.clone(),
                e.value.clone(),
                e.reference.clone(),
                e.joint.clone(),
                super::optional(e.loss_ratio),
                share(e.other_first_choice),
                e.gained.to_string(),
                e.lost.to_string(),
                e.pairs.to_string(),
            ]
        })
        .collect();
    for line in table(&header, &rows).lines() {
        out.push_str(&format!("  {line}\n"));
    }
    if effects.len() > EFFECTS {
        out.push_str(&format!("  and {} more, see summary.json\n", effects.len() - EFFECTS));
    }
    let note = "Loss times: geometric mean over the pairs of points that differ in this parameter alone and have a design at both \
                values. Gained, lost: points that have a design at this value only, or at the other only.";
    out.push_str(&format!("\n  {}\n", wrap(note, 2)));
    out
}

/// For programs.
pub fn json_text(summary: &Summary) -> String {
    super::json_text(&serde_json::to_value(summary).unwrap_or_default())
}
