//! What a second source says otherwise.

use super::diff::sides;
use crate::table::paragraph;
use crate::{counted, number};
use gearwise_model::catalog::against::{APART, Against, share};
use gearwise_model::catalog::difference::{Became, Change, Difference};

fn changes(of: &[Difference]) -> impl Iterator<Item = (&Difference, &Change)> {
    of.iter().flat_map(|d| {
        let changes: &[Change] = if let Became::Changed(changes) = &d.became { changes } else { &[] };
        changes.iter().map(move |change| (d, change))
    })
}

/// For people.
pub fn text(found: &Against) -> String {
    let mut out = String::new();
    let mut part = |title: &str, of: &[Difference], line: &dyn Fn(&Change) -> String| {
        if of.is_empty() {
            return;
        }
        out.push_str(&paragraph(title, 0, 2));
        let mut last = "";
        for (difference, change) in changes(of) {
            if difference.id != last {
                out.push_str(&paragraph(&format!("{} {}", difference.kind, difference.id), 2, 4));
                last = &difference.id;
            }
            out.push_str(&paragraph(&line(change), 4, 6));
        }
        out.push('\n');
    };
    part(&format!("More than {} % apart:", number(100.0 * APART)), &found.apart, &|change| {
        let [own, second] = sides(change);
        let by = share(change)
            .map_or_else(String::new, |s| format!(" ({}{} %)", if s > 0.0 { "+" } else { "" }, number(100.0 * s)));
        format!("{}: {own} here, {second} there{by}", change.column)
    });
    part("In one of them alone:", &found.lacking, &|change| {
        let [own, second] = sides(change);
        match change.before {
            Some(_) => format!("{}: {own} here", change.column),
            None => format!("{}: {second} there", change.column),
        }
    });
    if !found.conventions.is_empty() {
        let line = format!(
            "Ampere, terminals or winding do not mean the same in both, so that electrical numbers are not compared: {}",
            found.conventions.join(", ")
        );
        out.push_str(&paragraph(&line, 0, 2));
    }
    let (apart, lacking) = (changes(&found.apart).count(), changes(&found.lacking).count());
    let line = format!(
        "{} in both, {} here alone, {} there alone; {} compared, {} more than {} % apart, {} in one of them alone.",
        counted(found.both, "row"),
        found.own,
        found.second,
        counted(found.compared, "number"),
        apart,
        number(100.0 * APART),
        lacking
    );
    out.push_str(&paragraph(&line, 0, 2));
    let nothing = match (found.both, found.compared) {
        (0, _) => "Nothing is compared: no id is in both. `--map IDS.csv` says which rows belong together.",
        (_, 0) => "Nothing is compared: no number is in both with the same meaning.",
        _ => return out,
    };
    out.push_str(&paragraph(nothing, 0, 2));
    out
}

/// As rows: one for each number.
pub fn csv(found: &Against) -> String {
    let all: Vec<Difference> = found.apart.iter().chain(&found.lacking).cloned().collect();
    super::diff::csv(&all)
}
