//! Cells of CSV files, as every one that the program writes has them.

use std::borrow::Cow;

/// Letters that make a spreadsheet take a cell for a formula and run it, also in their full width.
const RUNS: [char; 8] = ['=', '+', '-', '@', '＝', '＋', '－', '＠'];

/// A text as it stands in a cell of the CSV files that are written: what a spreadsheet would run has a `'` before it,
/// and [`unguarded`] takes that away again. A number stays as it is.
///
/// ```
/// use gearwise_model::words::csv::{guarded, unguarded};
/// assert_eq!(guarded("=cmd|' /C calc'!A0"), "'=cmd|' /C calc'!A0");
/// assert_eq!((guarded("-1.5").as_ref(), guarded("knee").as_ref()), ("-1.5", "knee"));
/// for text in ["-left", "'-left", "'quoted'", "+5", "=1", "@x", "\tx", ""] {
///     assert_eq!(unguarded(&guarded(text)), text);
/// }
/// ```
pub fn guarded(text: &str) -> Cow<'_, str> {
    if runs(text) && text.parse::<f64>().is_err() { format!("'{text}").into() } else { text.into() }
}

/// The text of a cell without the `'` that [`guarded`] has put before it.
pub fn unguarded(cell: &str) -> &str {
    cell.strip_prefix('\'').filter(|_| runs(cell)).unwrap_or(cell)
}

/// Whether a spreadsheet would run the text, or would were it not for quotes before it.
fn runs(text: &str) -> bool {
    let bare = text.trim_start_matches('\'');
    bare.starts_with(['\t', '\r', '\n']) || bare.trim_start().starts_with(RUNS)
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
