//! Tables for people: as wide as the terminal, or 120 columns where there is none.

use comfy_table::{Cell, CellAlignment, ColumnConstraint, ContentArrangement, Table, presets};

/// Width of output that does not go to a terminal, so that it is the same everywhere.
pub const PLAIN_WIDTH: u16 = 120;

/// Makes a table; columns whose header starts with `>` are right-aligned, and names of motors and
/// gears are never broken.
pub fn table(header: &[&str], rows: &[Vec<String>]) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_content_arrangement(ContentArrangement::Dynamic);
    if !table.is_tty() {
        table.set_width(PLAIN_WIDTH);
    }
    let right: Vec<bool> = header.iter().map(|h| h.starts_with('>')).collect();
    let cell = |text: &str, right: bool| {
        Cell::new(text).set_alignment(if right { CellAlignment::Right } else { CellAlignment::Left })
    };
    table.set_header(header.iter().zip(&right).map(|(h, r)| cell(h.trim_start_matches('>'), *r)));
    for row in rows {
        table.add_row(row.iter().zip(&right).map(|(text, r)| cell(text, *r)));
    }
    for (i, name) in header.iter().enumerate() {
        if let Some(column) = table.column_mut(i) {
            column.set_padding((if i == 0 { 0 } else { 1 }, 1));
            if matches!(*name, "motor" | "gear") {
                column.set_constraint(ColumnConstraint::ContentWidth);
            }
        }
    }
    let text: Vec<String> = table.lines().map(|l| l.trim_end().to_string()).collect();
    text.join("\n") + "\n"
}

/// Wraps text at the width of a table, each line after the first indented; the first line leaves room
/// for what stands before it, at most as wide as the indent.
pub fn wrap(text: &str, indent: usize) -> String {
    let width = usize::from(PLAIN_WIDTH);
    let (mut lines, mut line) = (Vec::new(), String::new());
    for word in text.split_whitespace() {
        let room = width.saturating_sub(indent);
        if !line.is_empty() && line.chars().count() + 1 + word.chars().count() > room {
            lines.push(std::mem::take(&mut line));
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line.push_str(word);
    }
    lines.push(line);
    lines.join(&format!("\n{}", " ".repeat(indent)))
}
