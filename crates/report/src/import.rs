//! What an import read, refused and assumed, and which files it wrote.

use std::path::Path;

use super::table::{Column, Table, paragraph};
use gearwise_model::catalog::import::{Holds, Import, Place, Remark, RemarkKind};

/// A catalogue file that was written.
#[derive(Debug)]
pub struct Written<'a> {
    /// Its path.
    pub path: &'a Path,
    /// How many rows it has.
    pub rows: usize,
}

fn word(kind: RemarkKind) -> &'static str {
    match kind {
        RemarkKind::Refused => "refused",
        RemarkKind::Assumed => "assumed",
        RemarkKind::LeftOut => "left_out",
    }
}

/// The remarks of one kind by reason: in the order in which the reasons first occur.
fn by_reason(import: &Import, kind: RemarkKind) -> Vec<(&'static str, Vec<&Remark>)> {
    let mut groups: Vec<(&'static str, Vec<&Remark>)> = Vec::new();
    for remark in import.remarks_of(kind) {
        match groups.iter_mut().find(|(code, _)| *code == remark.code) {
            Some((_, group)) => group.push(remark),
            None => groups.push((remark.code, vec![remark])),
        }
    }
    groups
}

fn line(remark: &Remark) -> String {
    let Place { file, line, column } = &remark.place;
    let key = if remark.key.is_empty() { String::new() } else { format!("{}: ", remark.key) };
    paragraph(&format!("{file}:{line}:{column}: {key}{}", remark.message), 2, 6)
}

/// For people; `rows` lists every assumption with its row, else one example of each.
pub fn text(import: &Import, written: &[Written], rows: bool) -> String {
    let cells = |cells: [&str; 5]| cells.map(String::from).to_vec();
    let files = import.files.iter().map(|f| {
        let [all, taken, refused] = [f.rows, f.taken, f.rows - f.taken].map(|n| n.to_string());
        cells([&f.file, f.holds.word(), &all, &taken, &refused])
    });
    let [rows_read, taken, refused] = ["rows", "taken", "refused"].map(|heading| Column::number(heading, ""));
    let columns = vec![Column::name("file"), Column::name("holds"), rows_read, taken, refused];
    let mut out = Table::new(columns).rows(files).text();
    let counts = format!(
        "{} and {}; {} compatible by the database.",
        gearwise_model::words::counted(import.motors.len(), "motor"),
        gearwise_model::words::counted(import.gears.len(), "gear"),
        gearwise_model::words::counted(import.compatible_pairs, "pair")
    );
    out.push_str(&format!("\n{}", paragraph(&counts, 0, 2)));
    out.push_str("\nAssumed of every row\n");
    for assumption in &import.assumptions {
        out.push_str(&paragraph(assumption, 2, 4));
    }
    for (kind, title) in [
        (RemarkKind::Assumed, "Assumed of single rows"),
        (RemarkKind::LeftOut, "Left out"),
        (RemarkKind::Refused, "Refused"),
    ] {
        let groups = by_reason(import, kind);
        let count: usize = groups.iter().map(|(_, group)| group.len()).sum();
        out.push_str(&format!("\n{title}: {count}\n"));
        for (code, group) in groups {
            // What was refused is always listed; of the rest an example says what is meant.
            let shown = if rows || kind == RemarkKind::Refused { group.len() } else { 1 };
            let example = if shown < group.len() { ", for example" } else { "" };
            out.push_str(&format!("{code}: {}{example}\n", group.len()));
            group.iter().take(shown).for_each(|remark| out.push_str(&line(remark)));
        }
    }
    if !rows && import.remarks.iter().any(|r| r.kind != RemarkKind::Refused) {
        out.push_str("\n`--rows` lists every row.\n");
    }
    out.push_str("\nWritten\n");
    for file in written {
        let rows = if file.rows == 1 { "row" } else { "rows" };
        out.push_str(&format!("  {}: {} {rows}\n", file.path.display(), file.rows));
    }
    out
}

/// As rows: every row that was taken, and every remark.
pub fn csv(import: &Import) -> String {
    let taken = |holds: Holds, id: &str, key: &str, place: &Option<Place>| {
        let place = place.clone().unwrap_or(Place { file: String::new(), line: 0, column: 0 });
        let line = if place.line > 0 { place.line.to_string() } else { String::new() };
        vec!["taken".into(), place.file, line, String::new(), key.into(), holds.word().into(), id.into()]
    };
    let motors = import.motors.iter().map(|m| taken(Holds::Motors, &m.item.id, &m.key, &m.place));
    let gears = import.gears.iter().map(|g| taken(Holds::Gears, &g.item.id, &g.key, &g.place));
    let remarks = import.remarks.iter().map(|r| {
        let Place { file, line, column } = &r.place;
        let (line, column) = (line.to_string(), column.to_string());
        vec![word(r.kind).into(), file.clone(), line, column, r.key.clone(), r.code.into(), r.message.clone()]
    });
    super::csv_text(
        &["outcome", "file", "line", "column", "key", "code", "id_or_reason"],
        motors.chain(gears).chain(remarks),
    )
}
