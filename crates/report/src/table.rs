//! Tables and paragraphs for people, at one width.
//!
//! The one idea: a row and the lines beneath it are one thing ([`Row`]), and a table as a whole decides how it fits, so
//! that nobody takes printed lines apart. Numbers, units and names never fold. What does not fit is tried in this order:
//! units beneath their headings and prose in several lines; without the columns that may be dropped, which is said; each
//! row as a block of its own, with every column.

use std::sync::atomic::{AtomicUsize, Ordering};

use unicode_width::UnicodeWidthStr;

use super::tint;
use gearwise_model::input::tame;
use gearwise_model::units::{RATIO, UnitError, unit_of};

/// Width of text where nothing says another, so that it is the same everywhere.
pub const PLAIN_WIDTH: usize = 120;
/// Nothing is laid out for less.
const NARROWEST: usize = 20;
/// Between two columns.
const GAP: usize = 2;
/// Prose is not folded into a column narrower than this.
const LEAST_PROSE: usize = 20;
/// How far the lines beneath a row are indented against it, and how far what they continue on.
const DETAILS: [usize; 2] = [3, 5];

static WIDTH: AtomicUsize = AtomicUsize::new(PLAIN_WIDTH);

/// The width that text is made for \[columns\]: [`PLAIN_WIDTH`], unless the program was told another.
pub fn width() -> usize {
    WIDTH.load(Ordering::Relaxed)
}

/// Makes text for another width from here on: what the command line does once, at its start.
pub fn set_width(columns: usize) {
    WIDTH.store(columns.max(NARROWEST), Ordering::Relaxed);
}

/// The width of text: what `COLUMNS` says, else the terminal's, else [`PLAIN_WIDTH`].
///
/// ```
/// use gearwise_report::table::decide;
/// assert_eq!((decide(None, None), decide(None, Some(80))), (120, 80));
/// assert_eq!((decide(Some("60"), Some(80)), decide(Some("wide"), Some(80))), (60, 80));
/// ```
pub fn decide(columns: Option<&str>, terminal: Option<usize>) -> usize {
    let said = columns.and_then(|text| text.trim().parse().ok()).filter(|n| *n > 0);
    said.or(terminal).unwrap_or(PLAIN_WIDTH).max(NARROWEST)
}

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// Right-aligned, never folded.
    Number,
    /// A name, or a few words that are read as one: never folded.
    Name,
    /// Text that may be folded at spaces.
    Prose,
}

/// A column: its heading, unit and what it holds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    heading: String,
    unit: String,
    kind: Kind,
    dropped: Option<u8>,
}

impl Column {
    fn new(heading: impl Into<String>, unit: &str, kind: Kind) -> Column {
        let unit = if unit == "1" { "" } else { unit };
        Column { heading: heading.into(), unit: unit.into(), kind, dropped: None }
    }

    /// Numbers in a unit, empty or `1` for none. A line end in a heading is where it may be broken.
    pub fn number(heading: impl Into<String>, unit: &str) -> Column {
        Column::new(heading, unit, Kind::Number)
    }

    /// Names: of motors, gears, limits, joints, files.
    pub fn name(heading: impl Into<String>) -> Column {
        Column::new(heading, "", Kind::Name)
    }

    /// Sentences, which may be folded at spaces.
    pub fn prose(heading: impl Into<String>) -> Column {
        Column::new(heading, "", Kind::Prose)
    }

    /// May be left out where the width does not suffice, the least `order` first; without this a column stays.
    #[must_use]
    pub fn dropped(mut self, order: u8) -> Column {
        self.dropped = Some(order);
        self
    }

    /// The heading as pages read it: `>` before numbers, the unit in brackets.
    pub fn of_page(&self) -> String {
        let mark = if self.kind == Kind::Number { ">" } else { "" };
        format!("{mark}{}", self.in_one_line())
    }

    fn in_one_line(&self) -> String {
        let heading = self.heading.replace('\n', " ");
        if self.unit.is_empty() { heading } else { format!("{heading} [{}]", self.unit) }
    }

    /// The heading as lines.
    fn lines(&self, broken: bool) -> Vec<String> {
        if !broken {
            return vec![self.in_one_line()];
        }
        let unit = (!self.unit.is_empty()).then(|| format!("[{}]", self.unit));
        self.heading.split('\n').map(str::to_string).chain(unit).collect()
    }
}

/// A row and what is said beneath it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Row {
    /// Its cells, one for each column.
    pub cells: Vec<String>,
    /// What is said of it, a paragraph each.
    pub details: Vec<String>,
}

/// A table.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Table {
    columns: Vec<Column>,
    rows: Vec<Row>,
    indent: usize,
    elsewhere: &'static str,
}

/// How the columns that are shown fit: their numbers and widths, and whether headings are broken.
struct Layout {
    shown: Vec<(usize, usize)>,
    broken: bool,
}

impl Table {
    /// A table without rows.
    pub fn new(columns: Vec<Column>) -> Table {
        Table { columns, ..Table::default() }
    }

    /// Indented by so many columns.
    #[must_use]
    pub fn indented(mut self, indent: usize) -> Table {
        self.indent = indent;
        self
    }

    /// With the options that show the columns, too, that this table may have to drop.
    #[must_use]
    pub fn also_in(mut self, elsewhere: &'static str) -> Table {
        self.elsewhere = elsewhere;
        self
    }

    /// With rows of which nothing more is said.
    #[must_use]
    pub fn rows(mut self, rows: impl IntoIterator<Item = Vec<String>>) -> Table {
        rows.into_iter().for_each(|cells| self.push(cells, Vec::new()));
        self
    }

    /// Adds a row with what is said beneath it.
    pub fn push(&mut self, cells: Vec<String>, details: Vec<String>) {
        // What comes from files has neither line ends nor what drives a terminal, so that a row is what it seems.
        let clean = |cell: String| tame(&cell).replace(['\n', '\r', '\t'], " ");
        self.rows.push(Row { cells: cells.into_iter().map(clean).collect(), details });
    }

    /// Whether it has no rows.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// As text, for the width that was decided.
    pub fn text(&self) -> String {
        self.text_at(width())
    }

    /// As text of a width \[columns\].
    pub fn text_at(&self, width: usize) -> String {
        let room = width.saturating_sub(self.indent);
        match self.layout(room) {
            Some(layout) => self.side_by_side(&layout, width),
            None => self.stacked(width),
        }
    }

    /// The layout with the most columns that fits, if one does.
    fn layout(&self, room: usize) -> Option<Layout> {
        let mut order: Vec<(u8, std::cmp::Reverse<usize>)> = Vec::new();
        for (index, column) in self.columns.iter().enumerate() {
            order.extend(column.dropped.map(|d| (d, std::cmp::Reverse(index))));
        }
        order.sort_unstable();
        (0..=order.len()).find_map(|dropped| {
            let gone = |index: usize| order[..dropped].iter().any(|(_, i)| i.0 == index);
            let shown: Vec<usize> = (0..self.columns.len()).filter(|i| !gone(*i)).collect();
            [false, true].into_iter().find_map(|broken| self.fitted(&shown, broken, room))
        })
    }

    /// The columns at their widths, if they fit; prose gives way.
    fn fitted(&self, shown: &[usize], broken: bool, room: usize) -> Option<Layout> {
        let bounds: Vec<(usize, usize)> = shown.iter().map(|i| self.bounds(*i, broken)).collect();
        let mut widths: Vec<usize> = bounds.iter().map(|(least, _)| *least).collect();
        let mut spare = room.checked_sub(widths.iter().sum::<usize>() + GAP * shown.len().saturating_sub(1))?;
        while spare > 0 {
            // The narrowest of those that want more, so that all prose grows alike.
            let wanting = (0..widths.len()).filter(|i| widths[*i] < bounds[*i].1);
            let Some(grows) = wanting.min_by_key(|i| widths[*i]) else { break };
            widths[grows] += 1;
            spare -= 1;
        }
        Some(Layout { shown: shown.iter().copied().zip(widths).collect(), broken })
    }

    /// The least and the natural width of a column.
    fn bounds(&self, index: usize, broken: bool) -> (usize, usize) {
        let column = &self.columns[index];
        let heading = column.lines(broken).iter().map(|l| l.width()).max().unwrap_or(0);
        let cells = || self.rows.iter().filter_map(|row| row.cells.get(index));
        let natural = cells().map(|c| c.width()).max().unwrap_or(0).max(heading);
        if column.kind != Kind::Prose {
            return (natural, natural);
        }
        let word = cells().flat_map(|c| c.split(' ')).map(UnicodeWidthStr::width).max().unwrap_or(0);
        (word.max(heading).max(LEAST_PROSE).min(natural), natural)
    }

    fn side_by_side(&self, layout: &Layout, width: usize) -> String {
        let shown = &layout.shown;
        let headings = shown.iter().map(|(i, _)| self.columns[*i].lines(layout.broken)).collect();
        let mut out = self.lines(shown, headings);
        for row in &self.rows {
            let cells = shown.iter().map(|(i, width)| self.cell_lines(row, *i, *width)).collect();
            out.push_str(&self.lines(shown, cells));
            out.push_str(&self.details(row, width));
        }
        out + &self.left_out(layout, width)
    }

    /// The lines of a cell of a given width.
    fn cell_lines(&self, row: &Row, index: usize, width: usize) -> Vec<String> {
        let cell = row.cells.get(index).map_or("", String::as_str);
        if self.columns[index].kind == Kind::Prose { folded(cell, width) } else { vec![cell.to_string()] }
    }

    /// Cells of several lines next to each other.
    fn lines(&self, shown: &[(usize, usize)], cells: Vec<Vec<String>>) -> String {
        let height = cells.iter().map(Vec::len).max().unwrap_or(0);
        let line = |k: usize| {
            let mut line = " ".repeat(self.indent);
            for (place, ((index, width), cell)) in shown.iter().zip(&cells).enumerate() {
                let text = cell.get(k).map_or("", String::as_str);
                let blank = " ".repeat(width.saturating_sub(text.width()));
                let gap = " ".repeat(if place == 0 { 0 } else { GAP });
                line += &match self.columns[*index].kind {
                    Kind::Number => format!("{gap}{blank}{text}"),
                    Kind::Name | Kind::Prose => format!("{gap}{text}{blank}"),
                };
            }
            format!("{}\n", line.trim_end())
        };
        (0..height).map(line).collect()
    }

    fn details(&self, row: &Row, width: usize) -> String {
        let [first, rest] = DETAILS.map(|more| self.indent + more);
        row.details.iter().map(|text| paragraph_at(text, first, rest, width)).collect()
    }

    /// Which columns are not shown, and where they are.
    fn left_out(&self, layout: &Layout, width: usize) -> String {
        let out = |i: &usize| layout.shown.iter().all(|(shown, _)| shown != i);
        let names: Vec<String> =
            (0..self.columns.len()).filter(out).map(|i| self.columns[i].heading.replace('\n', " ")).collect();
        if names.is_empty() {
            return String::new();
        }
        let least: usize = (0..self.columns.len()).map(|i| self.bounds(i, true).0).sum();
        let needed = least + GAP * (self.columns.len() - 1) + self.indent;
        let or = if self.elsewhere.is_empty() { String::new() } else { format!(", and in {}", self.elsewhere) };
        let text = format!("Not shown at {width} columns: {} (shown from {needed} columns on{or})", names.join(", "));
        paragraph_at(&text, self.indent, self.indent + 2, width)
    }

    /// Each row as a block: a line for each cell, and what is said beneath it.
    fn stacked(&self, width: usize) -> String {
        let heading = |c: &Column| c.heading.replace('\n', " ");
        let label = self.columns.iter().map(|c| heading(c).width()).max().unwrap_or(0);
        let block = |row: &Row| {
            let mut out = String::new();
            for (column, cell) in self.columns.iter().zip(&row.cells).filter(|(_, cell)| !cell.is_empty()) {
                let unit = if column.unit.is_empty() || cell == "–" { "" } else { &format!(" {}", column.unit) };
                let hang = self.indent + label + GAP;
                let heading = heading(column);
                let blank = " ".repeat(label - heading.width() + GAP);
                let head = format!("{}{heading}", " ".repeat(self.indent));
                out += &if heading.is_empty() {
                    // What says by itself what it is stands alone, as a title.
                    format!("{head}{cell}{unit}\n")
                } else if column.kind == Kind::Prose {
                    format!("{head}{blank}{}\n", wrap_at(cell, hang, width))
                } else if hang + cell.width() + unit.width() > width {
                    format!("{head}\n{}{cell}{unit}\n", " ".repeat(self.indent + GAP))
                } else {
                    format!("{head}{blank}{cell}{unit}\n")
                };
            }
            out + &self.details(row, width)
        };
        self.rows.iter().map(block).collect::<Vec<_>>().join("\n")
    }
}

/// A paragraph with its line end: its first line indented by `first`, the others by `rest`, which is not less.
pub fn paragraph(text: &str, first: usize, rest: usize) -> String {
    paragraph_at(text, first, rest, width())
}

/// [`paragraph`] of a width \[columns\].
pub fn paragraph_at(text: &str, first: usize, rest: usize, width: usize) -> String {
    format!("{}{}\n", " ".repeat(first), wrap_at(text, rest, width))
}

/// Wraps text at the width that was decided, each line after the first indented; the first line leaves room
/// for what stands before it, at most as wide as the indent.
pub fn wrap(text: &str, indent: usize) -> String {
    wrap_at(text, indent, width())
}

/// [`wrap`] at a width \[columns\].
pub fn wrap_at(text: &str, indent: usize, width: usize) -> String {
    folded(text, width.saturating_sub(indent)).join(&format!("\n{}", " ".repeat(indent)))
}

/// The lines of a text, at most as wide as the room where no single word is wider.
fn folded(text: &str, room: usize) -> Vec<String> {
    let (mut lines, mut line) = (Vec::new(), String::new());
    for part in parts(text, room) {
        if !line.is_empty() && line.width() + 1 + part.width() > room {
            lines.push(std::mem::take(&mut line));
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line.push_str(&part);
    }
    lines.push(line);
    lines
}

/// What a line may not end within: words, and numbers with their signs and units, as far as there is room.
fn parts(text: &str, room: usize) -> Vec<String> {
    let mut parts: Vec<String> = Vec::new();
    let mut before = "";
    for word in text.split_whitespace() {
        match parts.last_mut() {
            Some(last) if held(before, word) && last.width() + 1 + word.width() <= room => {
                last.push(' ');
                last.push_str(word);
            }
            _ => parts.push(word.to_string()),
        }
        before = word;
    }
    parts
}

/// Whether a line may not end between two words: at a sign that stands between numbers, and before a unit.
fn held(before: &str, after: &str) -> bool {
    let (before, after) = (&*tint::plain(before), &*tint::plain(after));
    const SIGNS: [&str; 5] = ["=", "±", "≤", "≥", "×"];
    let number = before.trim_start_matches(['(', '[', '+', '-', '−', '±']).parse::<f64>().is_ok();
    let unit = || {
        let unit = after.trim_end_matches(['.', ',', ';', ':', ')', ']']);
        unit == "degC" || matches!(unit_of(unit, &RATIO), Ok(_) | Err(UnitError::WrongDimension(_)))
    };
    SIGNS.contains(&after) || SIGNS.contains(&before) || (number && unit())
}
