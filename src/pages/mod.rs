//! The pages of `docs/` that are made from the program's own registries, so that they cannot go stale: a test
//! compares the committed pages with what is made here.

mod catalogue;
pub mod commands;
mod effects;
mod estimates;
pub mod formats;
mod limits;
mod metrics;
mod rules;
#[cfg(feature = "schema")]
pub mod schema;
mod simulators;

/// A page.
#[derive(Debug)]
pub struct Page {
    /// File name in `docs/`.
    pub file: &'static str,
    /// Its text.
    pub text: fn() -> String,
}

/// Every page but that of the commands, which belongs to the command line.
pub const PAGES: &[Page] = &[
    Page { file: "catalogue.md", text: catalogue::text },
    Page { file: "effects.md", text: effects::text },
    Page { file: "estimates.md", text: estimates::text },
    Page { file: "limits.md", text: limits::text },
    Page { file: "metrics.md", text: metrics::text },
    Page { file: "formats.md", text: formats::text },
    Page { file: "rules.md", text: rules::text },
    Page { file: "simulator-formats.md", text: simulators::text },
];

/// First line of every page: who made it.
const MADE: &str = "<!-- Made by `gearwise docs`; change the program, not this page. -->\n\n";

/// A Markdown table.
fn table(header: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let line = |cells: Vec<String>| {
        let cells = cells.into_iter().map(|c| c.replace('|', "\\|").replace('\n', " "));
        format!("| {} |\n", cells.collect::<Vec<_>>().join(" | "))
    };
    let mut out = line(header.iter().map(|h| (*h).to_string()).collect());
    out.push_str(&format!("|{}\n", "---|".repeat(header.len())));
    rows.into_iter().for_each(|row| out.push_str(&line(row)));
    out
}

/// A documentation comment as Markdown: `\[` was for rustdoc.
fn plain(doc: &str) -> String {
    doc.trim().replace("\\[", "[").replace("\\]", "]")
}

/// As code, unless there is nothing.
fn code(text: &str) -> String {
    if text.is_empty() { String::new() } else { format!("`{text}`") }
}
