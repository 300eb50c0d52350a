//! Results for people and programs: one file for each kind of result, which gives its table, its
//! JSON and its CSV from the same facts.

pub mod audit;
pub mod characterize;
pub mod check;
pub mod compare;
pub mod currents;
pub mod design_file;
pub mod explain;
pub mod export;
pub mod file;
pub mod fitted;
pub mod forward;
pub mod handy;
pub mod html;
pub mod identify;
pub mod import;
pub mod optimize;
pub mod pages;
pub mod pareto;
pub mod plot;
mod prune;
pub mod rank;
pub mod remake;
pub mod robot;
pub mod robust;
pub mod rules;
pub mod spring;
pub mod study;
pub mod sweep;
pub mod table;
pub mod torques;
pub mod unjudged;
pub mod xml;

use serde_json::Value;

use crate::input::csv::guarded;

/// How many different motors there are, in words.
///
/// ```
/// use gearwise::report::different_motors;
/// assert_eq!((different_motors(1).as_str(), different_motors(3).as_str()), ("one motor", "3 different motors"));
/// ```
pub fn different_motors(count: usize) -> String {
    if count == 1 { "one motor".into() } else { format!("{count} different motors") }
}

/// A number with four significant digits, without needless zeros.
///
/// ```
/// use gearwise::report::number;
/// assert_eq!(number(0.064366), "0.06437");
/// assert_eq!(number(1200.0), "1200");
/// assert_eq!(number(9.01e-6), "9.010e-6");
/// ```
pub fn number(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if value.is_infinite() {
        return if value > 0.0 { "∞".into() } else { "−∞".into() };
    }
    if value.is_nan() {
        return "–".into();
    }
    let magnitude = value.abs().log10().floor() as i32;
    if !(-4..7).contains(&magnitude) {
        return format!("{value:.3e}");
    }
    let digits = (3 - magnitude).max(0) as usize;
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_string() } else { text }
}

/// `number`, or a dash where the value is unknown.
pub fn optional(value: Option<f64>) -> String {
    value.map_or_else(|| "–".into(), number)
}

/// A value with its unit; a pure number has none.
pub(crate) fn with_unit(value: f64, unit: &str) -> String {
    format!("{} {}", number(value), if unit == "1" { "" } else { unit }).trim_end().to_string()
}

/// `1 joint`, `2 joints`.
pub(crate) fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// What a design that is not proved leaves open: by how much of its own value a better one may be less. `gap` is
/// `(objective − lower bound)/|objective|`. Rounded up to two digits, so that "up to" is true.
pub(crate) fn may_be_beaten(gap: f64) -> String {
    let percent = 100.0 * gap;
    if percent == 0.0 {
        return "may be beaten by what rounding leaves".into();
    }
    let step = 10.0_f64.powf(percent.log10().floor() - 1.0);
    // What is two digits already stays.
    let up = (percent / step * (1.0 - 1e-9)).ceil() * step;
    format!("may be beaten by up to {} %", number(up))
}

/// JSON text, two spaces deep, with a final newline.
pub fn json_text(value: &Value) -> String {
    let mut text = serde_json::to_string_pretty(value).unwrap_or_default();
    text.push('\n');
    text
}

/// Writes one row of a CSV file: every one that the program writes goes through here, so that no spreadsheet runs
/// what stands in a cell (see [`guarded`]).
///
/// # Errors
/// Those of the writer.
pub fn csv_row<'a, W: std::io::Write>(
    writer: &mut csv::Writer<W>,
    cells: impl IntoIterator<Item = &'a str>,
) -> csv::Result<()> {
    for cell in cells {
        writer.write_field(guarded(cell).as_ref())?;
    }
    writer.write_record(None::<&[u8]>)
}

/// CSV text of a header and rows.
pub fn csv_text(header: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    // Writing to memory does not fail; rows have the header's length by construction.
    let _ = csv_row(&mut writer, header.iter().copied());
    for row in rows {
        let _ = csv_row(&mut writer, row.iter().map(String::as_str));
    }
    writer.into_inner().ok().and_then(|bytes| String::from_utf8(bytes).ok()).unwrap_or_default()
}

/// A number for CSV: shortest text that reads back as the same number; empty where unknown.
pub fn csv_number(value: Option<f64>) -> String {
    value.filter(|v| v.is_finite()).map_or_else(String::new, |v| v.to_string())
}

#[cfg(test)]
mod tests {
    use super::may_be_beaten;

    /// By the definition of the gap the bound is `(1 − gap)` times the objective: so much less may a better one be.
    #[test]
    fn what_may_be_beaten_is_said_by_how_much_and_never_too_little() {
        for (gap, told) in [
            (0.9391, "may be beaten by up to 94 %"),
            (0.94, "may be beaten by up to 94 %"),
            (0.5, "may be beaten by up to 50 %"),
            (1.0e-5, "may be beaten by up to 0.001 %"),
            (1.201, "may be beaten by up to 130 %"),
            (0.0, "may be beaten by what rounding leaves"),
        ] {
            assert_eq!(may_be_beaten(gap), told);
        }
        for k in 1..400 {
            let gap = 1e-9 * 1.06_f64.powi(k);
            let told = may_be_beaten(gap);
            let percent: f64 = told.split_whitespace().rev().nth(1).unwrap().parse().unwrap();
            assert!(percent >= 100.0 * gap * (1.0 - 1e-8) && percent <= 111.0 * gap, "{gap}: {told}");
        }
    }
}
