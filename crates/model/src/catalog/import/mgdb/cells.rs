//! The cells of one row, and what there is to say of it.

use super::super::{Lines, Place, Remark, RemarkKind};
use super::Ids;
use crate::input::csv::Table;
use crate::input::{Problem, Range};
use crate::units;

/// A key longer than this is no name \[bytes\].
const LONGEST_KEY: usize = 200;

/// One row of motors or gears. What is wrong with it is collected, and refuses it.
pub struct Cells<'t> {
    table: &'t Table,
    row: usize,
    lines: &'t Lines<'t>,
    problems: Vec<Problem>,
    code: &'static str,
    remarks: Vec<(RemarkKind, &'static str, String)>,
    infinite: Vec<&'static str>,
}

impl<'t> Cells<'t> {
    pub fn new(table: &'t Table, row: usize, lines: &'t Lines<'t>) -> Cells<'t> {
        let (problems, remarks, infinite) = (Vec::new(), Vec::new(), Vec::new());
        Cells { table, row, lines, problems, code: "unusable-value", remarks, infinite }
    }

    /// Where the row stands.
    pub fn place(&self) -> Place {
        self.lines.place(self.table.row_span(self.row).start)
    }

    /// The row's key, which no row before it has.
    pub fn key(&mut self, ids: &Ids) -> String {
        let Some(key) = self.table.text(self.row, "key") else {
            self.refuse("key", "missing-key", "the row has no key");
            return String::new();
        };
        if key.len() > LONGEST_KEY {
            let message = format!("the key has {} bytes: expected at most {LONGEST_KEY}", key.len());
            self.refuse("key", "key-too-long", message);
        }
        if let Some(first) = ids.by_key.get(key) {
            let message = format!("duplicate key, first in {}:{}; the first row is kept", first.file, first.line);
            self.refuse("key", "duplicate-key", message);
        }
        key.to_string()
    }

    /// The text of a cell; `""` where it is blank.
    pub fn text(&self, column: &str) -> &'t str {
        self.table.text(self.row, column).unwrap_or("")
    }

    /// The number in a cell; `None` where it is blank, NaN or inf. What is no number of the range
    /// refuses the row.
    pub fn number(&mut self, column: &'static str, range: Range) -> Option<f64> {
        let text = self.text(column);
        match text.to_ascii_lowercase().as_str() {
            "" | "nan" => return None,
            "inf" | "+inf" | "infinity" => {
                self.infinite.push(column);
                return None;
            }
            _ => {}
        }
        match units::number_value(text) {
            Ok(value) if range.contains(value) => return Some(value),
            Ok(value) => {
                let message = format!("{column} is {value}: expected {}", range.expected());
                self.refuse(column, "value-out-of-range", message);
            }
            Err(error) => {
                let message = format!("{column}: {}", error.message(&units::RATIO));
                self.refuse(column, "not-a-number", message);
            }
        }
        None
    }

    /// The number in a cell without which the row is of no use.
    pub fn required(&mut self, column: &'static str, code: &'static str) -> Option<f64> {
        let before = self.problems.len();
        let value = self.number(column, Range::Positive);
        if value.is_none() && self.problems.len() == before {
            let shown = match self.text(column) {
                "" => "blank",
                other => other,
            };
            let message = format!("{column} is {shown}: expected {}", Range::Positive.expected());
            self.refuse(column, code, message);
        }
        value
    }

    /// Notes why the row cannot be taken.
    pub fn refuse(&mut self, column: &str, code: &'static str, message: impl Into<String>) {
        if self.problems.is_empty() {
            self.code = code;
        }
        self.problems.push(Problem::at(self.table.cell_span(self.row, column), message, ""));
    }

    /// Notes what is assumed of the row.
    pub fn assume(&mut self, code: &'static str, message: impl Into<String>) {
        self.remarks.push((RemarkKind::Assumed, code, message.into()));
    }

    /// Notes what the catalogue has no place for.
    pub fn leave_out(&mut self, code: &'static str, message: impl Into<String>) {
        self.remarks.push((RemarkKind::LeftOut, code, message.into()));
    }

    /// Hands over the remarks: those of a row that is taken, or the one that refuses it. Whether it is
    /// taken.
    pub fn finish(&mut self, remarks: &mut Vec<Remark>, key: &str) -> bool {
        if !self.problems.is_empty() {
            remarks.push(self.lines.refused(self.code, key, &self.problems));
            return false;
        }
        if !self.infinite.is_empty() {
            let message = format!("inf in {} is read as unknown", self.infinite.join(", "));
            self.assume("infinite-is-unknown", message);
        }
        let place = self.place();
        let remark = |(kind, code, message)| Remark { kind, code, place: place.clone(), key: key.to_string(), message };
        remarks.extend(self.remarks.drain(..).map(remark));
        true
    }

    /// Maker, and what the maker calls it: from the row, else from the folder and the key.
    pub fn maker_and_model(&mut self, key: &str, folder: &std::path::Path) -> (String, String) {
        let mut maker = self.text("manufacturer").to_string();
        if maker.is_empty() {
            maker = folder.file_name().map_or_else(|| "unknown maker".into(), |n| n.to_string_lossy().into_owned());
            self.assume("maker-from-folder", format!("manufacturer is blank: taken as `{maker}`, from the folder"));
        }
        let maker = match maker.as_str() {
            "Maxon" => "maxon".into(),
            "Faulhaber" => "FAULHABER".into(),
            "Tmotor" => "T-Motor".into(),
            _ => maker.replace('_', " "),
        };
        let model = match self.text("ID") {
            "" => key.to_string(),
            id => id.replace('_', " "),
        };
        (maker, model)
    }
}
