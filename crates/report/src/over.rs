//! What the best design is over one number of the requirement.

use super::said::proof;
use super::table::{Column, Table, paragraph};
use super::{csv_number, csv_text, number};
use gearwise_select::over::{Found, Looked, best};
use gearwise_select::remake::Chosen;

/// What was searched over, and what for.
#[derive(Debug, Clone)]
pub struct Asked {
    /// The key of the requirement.
    pub key: String,
    /// The unit of its values; empty for a bare number.
    pub unit: String,
    /// How many values of the grid.
    pub points: usize,
    /// What is minimised, and its unit.
    pub objective: (String, &'static str),
}

impl Asked {
    fn value(&self, looked: &Looked) -> String {
        if self.unit.is_empty() { number(looked.value) } else { format!("{} {}", number(looked.value), self.unit) }
    }
}

/// For people: the best value with its choice, then every value that was looked at.
pub fn text(asked: &Asked, all: &[Looked]) -> String {
    let (name, unit) = &asked.objective;
    let mut out = String::new();
    let heading = match best(all) {
        None => format!("{}: at none of {} values every joint has a choice", asked.key, all.len()),
        Some(found) => {
            let at_end = [all.first(), all.last()].into_iter().flatten().any(|end| end.value == found.value);
            let end = if at_end { ", the end of the range: a wider range may have less" } else { "" };
            let lost = found.found.iter().flatten().map(|of| of.between).sum::<f64>();
            let with = match lost > 0.0 {
                true => format!(", {} W of it in the transmission", number(lost)),
                false => String::new(),
            };
            let proved = match found.is_proved() {
                true => "Proved at that value, not between the values",
                false => "Not proved: a ratio at that value is not certified",
            };
            format!(
                "{} = {}: least {name} of the {} values looked at, {} {unit} over all actuators{with}{end}. {proved}.",
                asked.key,
                asked.value(found),
                all.len(),
                number(found.total().unwrap_or(f64::NAN)),
            )
        }
    };
    out.push_str(&paragraph(&heading, 0, 2));
    let joints: Vec<&str> = all
        .iter()
        .find_map(|looked| looked.found.as_ref().ok())
        .map_or_else(Vec::new, |found| found.iter().map(|f| f.joint.as_str()).collect());
    let mut columns = vec![Column::number(last_part(&asked.key), &asked.unit), Column::number(name.as_str(), unit)];
    for joint in &joints {
        columns.push(Column::name(*joint));
        columns.push(Column::number("N", ""));
    }
    columns.push(Column::name("proof").dropped(1));
    let mut table = Table::new(columns).also_in("`--csv`, `--json`");
    let mut not = Vec::new();
    for looked in all {
        match &looked.found {
            Err(why) => not.push((asked.value(looked), why.clone())),
            Ok(found) => {
                let mut row = vec![number(looked.value), looked.total().map_or_else(|| "–".into(), number)];
                for of in found {
                    match &of.choice {
                        Some(chosen) => row.extend([actuator(chosen), number(chosen.ratio)]),
                        None => row.extend(["no choice".into(), "–".into()]),
                    }
                }
                row.push(worst_proof(found));
                table.push(row, Vec::new());
            }
        }
    }
    if !table.is_empty() {
        out.push_str(&format!("\n{}", table.text()));
    }
    for (value, why) in not {
        out.push_str(&paragraph(&format!("At {value} it cannot be: {why}"), 0, 2));
    }
    out
}

fn last_part(key: &str) -> &str {
    key.rsplit('.').next().unwrap_or(key)
}

fn actuator(chosen: &Chosen) -> String {
    match &chosen.gear {
        Some(gear) => format!("{} + {gear}", chosen.motor),
        None => chosen.motor.clone(),
    }
}

/// The proof of the joint whose is the weakest.
fn worst_proof(found: &[Found]) -> String {
    let proofs: Vec<String> = found.iter().filter_map(|f| Some(proof(&f.choice.as_ref()?.certificate))).collect();
    let rank = |text: &String| (text == "not certified", text != "exact");
    proofs.into_iter().max_by_key(rank).unwrap_or_else(|| "–".into())
}

/// A row for each joint at each value.
pub fn csv(asked: &Asked, all: &[Looked]) -> String {
    let value = if asked.unit.is_empty() { "value".into() } else { format!("value [{}]", asked.unit) };
    let header = [&*value, "joint", "count", "motor", "gear", "ratio", "objective", "proof", "why_not"];
    let rows = all.iter().flat_map(|looked| {
        let value = csv_number(Some(looked.value));
        match &looked.found {
            Err(why) => {
                let mut row = vec![String::new(); header.len()];
                (row[0], row[8]) = (value, why.clone());
                vec![row]
            }
            Ok(found) => found.iter().map(|of| row(&value, of)).collect(),
        }
    });
    csv_text(&header, rows)
}

fn row(value: &str, of: &Found) -> Vec<String> {
    let chosen = of.choice.as_ref();
    vec![
        value.to_string(),
        of.joint.clone(),
        of.count.to_string(),
        chosen.map_or_else(String::new, |c| c.motor.clone()),
        chosen.and_then(|c| c.gear.clone()).unwrap_or_default(),
        csv_number(chosen.map(|c| c.ratio)),
        csv_number(chosen.map(|c| c.objective)),
        chosen.map_or_else(String::new, |c| proof(&c.certificate)),
        if chosen.is_none() { "no choice".into() } else { String::new() },
    ]
}
