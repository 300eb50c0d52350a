//! Pages: one self-contained file for each result, which opens without a network.
//!
//! The one idea: a command says *what* is on its page ([`Page`]: a headline, tables, figures, warnings), and
//! one place (`render`) makes the file, so that every page sorts, filters, highlights, prints and is safe in
//! the same way. All text from outside passes one escape; the page forbids itself everything but its own
//! script and style, which it names by their hashes. The page of a command is one file beside this one.

mod bars;
mod chain;
mod figure;
mod render;

mod asked;
pub mod audit;
pub mod characterize;
pub mod check;
pub mod compare;
pub mod explain;
pub mod explore;
pub mod export;
pub mod identify;
pub mod identify_robot;
pub mod optimize;
pub mod pareto;
pub mod rank;
mod robot;
pub mod robust;
pub mod sweep;
mod unjudged;

use std::path::Path;

pub use bars::Bars;
pub use chain::Chain;
pub use render::{Frame, application, fragment, policy, shown, text};

use super::plot::{self, Figure};
use gearwise_model::input::InputFile;
use gearwise_model::output;

/// More rows than this make a page slow; what is left out is said.
pub const MOST_ROWS: usize = 5000;

/// Whether what was asked is satisfied.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Verdict {
    /// There is nothing to satisfy.
    #[default]
    Information,
    /// It is.
    Satisfied,
    /// It is not.
    NotSatisfied,
}

impl From<bool> for Verdict {
    fn from(satisfied: bool) -> Verdict {
        if satisfied { Verdict::Satisfied } else { Verdict::NotSatisfied }
    }
}

/// A page.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Page {
    /// The command, `optimize`.
    pub command: &'static str,
    /// What it is about: the robot, the catalogue, the bench.
    pub title: String,
    /// Whether what was asked is satisfied.
    pub verdict: Verdict,
    /// What was asked, with which the page begins.
    pub asked: Vec<Part>,
    /// The answer in a sentence that a user can act on.
    pub headline: String,
    /// What stands under the headline, first the most important.
    pub summary: Vec<Part>,
    /// Sections, top to bottom.
    pub sections: Vec<Section>,
    /// What should be known before the result is used.
    pub warnings: Vec<String>,
    /// How the program was called; empty if not known.
    pub call: String,
    /// What the result rests on.
    pub inputs: Vec<InputFile>,
}

/// Parts under a title.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Section {
    /// Title.
    pub title: String,
    /// What is in it.
    pub parts: Vec<Part>,
}

impl Section {
    /// A section.
    pub fn new(title: impl Into<String>, parts: Vec<Part>) -> Section {
        Section { title: title.into(), parts }
    }
}

/// A part of a section.
#[derive(Debug, Clone, PartialEq)]
pub enum Part {
    /// A paragraph.
    Text(String),
    /// Lines of a list.
    List(Vec<String>),
    /// Text with its own line breaks and columns.
    Plain(String),
    /// A table.
    Table(Table),
    /// A figure; choosing a thing in it chooses it everywhere.
    Figure(Figure),
    /// What sums are made of.
    Bars(Bars),
    /// A robot joint by joint.
    Chain(Chain),
    /// A part that is closed at first, under its title.
    Folded(String, Box<Part>),
}

/// A table that can be sorted and filtered.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Table {
    /// What it shows.
    pub caption: String,
    /// Its columns.
    pub columns: Vec<Column>,
    /// How many of its columns, from the first, are shown at once; the others where they are asked for. 0: all.
    pub main: usize,
    /// Its rows, in the order in which they are first shown.
    pub rows: Vec<Row>,
}

/// A column.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Column {
    /// What it holds.
    pub name: String,
    /// Unit; empty for none.
    pub unit: String,
    /// Whether it is sorted as numbers.
    pub number: bool,
}

/// A row.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Row {
    /// The id of the thing it is about (a motor), as in [`Series::ids`](super::plot::Series::ids); may be empty.
    pub id: String,
    /// Its cells.
    pub cells: Vec<String>,
    /// Whether it is drawn back: it is not feasible.
    pub faint: bool,
}

impl Table {
    /// A table with the headers of a text table: `>` in front of numbers, the unit in brackets.
    pub fn new<S: AsRef<str>>(caption: impl Into<String>, header: &[S]) -> Table {
        let column = |name: &S| {
            let text = name.as_ref().trim().replace('\n', " ");
            let (number, text) = text.strip_prefix('>').map_or((false, text.as_str()), |rest| (true, rest));
            let (name, unit) = match text.rsplit_once('[') {
                Some((name, unit)) => (name.trim(), unit.trim_end_matches(']')),
                None => (text, ""),
            };
            Column { name: name.into(), unit: plot::unit(unit), number }
        };
        Table { caption: caption.into(), columns: header.iter().map(column).collect(), main: 0, rows: Vec::new() }
    }

    /// A table with the columns of a text table.
    pub fn of(caption: impl Into<String>, columns: &[super::table::Column]) -> Table {
        let header: Vec<String> = columns.iter().map(super::table::Column::of_page).collect();
        Table::new(caption, &header)
    }

    /// With rows that are about nothing in particular.
    #[must_use]
    pub fn rows(mut self, rows: impl IntoIterator<Item = Vec<String>>) -> Table {
        self.rows.extend(rows.into_iter().map(|cells| Row { cells, ..Row::default() }));
        self
    }

    /// With so many columns shown at once, the others where they are asked for.
    #[must_use]
    pub fn mainly(self, main: usize) -> Table {
        Table { main, ..self }
    }

    /// Adds a row about a motor.
    pub fn push(&mut self, id: &str, cells: Vec<String>) {
        self.rows.push(Row { id: id.into(), cells, faint: false });
    }

    /// The table as a part; nothing where it has no rows.
    pub fn part(self) -> Option<Part> {
        (!self.rows.is_empty()).then_some(Part::Table(self))
    }
}

/// A part that is closed at first; nothing where there is nothing in it.
fn folded(title: &str, part: Option<Part>) -> Option<Part> {
    part.map(|part| Part::Folded(title.into(), Box::new(part)))
}

/// The limit that leaves least, and what it leaves \[%\].
fn tightest(e: &gearwise_select::Evaluation) -> [String; 2] {
    let tightest = e.tightest();
    [
        tightest.map_or_else(|| "–".into(), |m| m.limit.into()),
        tightest.map_or_else(|| "–".into(), |m| crate::number((1000.0 * m.margin.max(0.0)).round() / 10.0)),
    ]
}

/// What of a motor is estimated, for a cell; blank where nothing is.
fn estimated(motor: &gearwise_model::catalog::Motor) -> String {
    motor.estimates.iter().map(|e| e.of.words()).collect::<Vec<_>>().join(", ")
}

/// One group of a figure as a part.
fn group_of(figure: &Figure, group: usize) -> Option<Part> {
    let group = figure.groups.get(group)?.clone();
    Some(Part::Figure(Figure { groups: vec![group], title: String::new(), ..figure.clone() }))
}

/// One panel of a figure as a part.
fn panel_of(figure: &Figure, group: usize, panel: usize) -> Option<Part> {
    let mut group = figure.groups.get(group)?.clone();
    group.panels = vec![group.panels.get(panel)?.clone()];
    Some(Part::Figure(Figure { groups: vec![group], title: String::new(), columns: 1, ..figure.clone() }))
}

/// Whether a page can be written there, as far as that can be told beforehand.
///
/// # Errors
/// In words: another ending than `.html`, a folder, or no folder for it.
pub fn check(path: &Path) -> Result<(), String> {
    let ending = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    if !matches!(ending.as_deref(), Some("html" | "htm")) {
        return Err(format!("`{}`: a page's name ends in .html", path.display()));
    }
    if path.is_dir() {
        return Err(format!("cannot write `{}`: it is a folder", path.display()));
    }
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => {
            Err(format!("cannot write `{}`: there is no folder `{}`", path.display(), folder.display()))
        }
        _ => Ok(()),
    }
}

/// Writes a page, whole or not at all.
///
/// # Errors
/// In words, where it cannot be written.
pub fn write(page: &Page, path: &Path) -> Result<(), String> {
    check(path)?;
    output::write_whole(path, text(page).as_bytes())
}
