//! The one place that makes a page: what is on it in, HTML out.

use std::fmt::Write as _;

use hmac_sha256::Hash as Sha256;
use serde_json::{Value, json};

use super::figure::{self, Ids};
use super::{MOST_ROWS, Page, Part, Section, Table, Verdict};
use crate::plot;

/// Characters that turn the direction of what follows: a name could make its neighbours read as something else.
fn turns(c: char) -> bool {
    matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{200e}' | '\u{200f}' | '\u{061c}')
}

/// Text that stands safely in the page; what turns the direction is shown as a mark.
fn escaped(text: &str) -> String {
    plot::escaped(text).replace(turns, "\u{fffd}")
}

/// A text as a page shows it: what turns the direction of a text is a mark.
pub fn shown(text: &str) -> String {
    text.replace(turns, "\u{fffd}")
}

/// Text for people, safe as [`escaped`], with units as print has them, wherever they stand in a sentence: `N·m`. Files and
/// calls, which are typed again, are not changed.
pub(super) fn printed(text: &str) -> String {
    let mut text = escaped(text);
    for (typed, print) in UNITS {
        if text.contains(typed) {
            text = text.replace(typed, print);
        }
    }
    text
}

/// Units as they are typed and as they are printed, the longer first.
const UNITS: [(&str, &str); 8] = [
    ("N*m*s/rad", "N·m·s/rad"),
    ("kg*m^2", "kg·m²"),
    ("g*cm^2", "g·cm²"),
    ("N*m", "N·m"),
    ("A*s", "A·s"),
    ("V*s", "V·s"),
    ("/s^2", "/s²"),
    ("/W^0.5", "/√W"),
];

/// The page's own style and that of the plotting library.
const STYLE: &str = concat!(include_str!("vendor/uPlot.min.css"), "\n", include_str!("page.css"));
/// The plotting library, its licence, and what makes the page move.
const SCRIPT: &str = concat!(
    "/*\nuPlot 1.6.32\n",
    include_str!("vendor/LICENSE"),
    "*/\n",
    include_str!("vendor/uPlot.iife.min.js"),
    "\n",
    include_str!("plot.js"),
    include_str!("ticks.js"),
    include_str!("table.js"),
    include_str!("page.js")
);

/// A page as text; the same page is the same text.
pub fn text(page: &Page) -> String {
    let (body, ids, figures) = written(|body| body.page(page));
    let data = json!({ "ids": ids.names(), "tones": figure::tones(), "figures": figures });
    let title = format!("{}: {}", page.command, page.title);
    document(&Frame { title, body: &body, style: "", script: "", data, asks: false })
}

/// What a page is made of.
#[derive(Debug)]
pub struct Frame<'f> {
    /// Its title.
    pub title: String,
    /// What stands in it: markup in which every text is escaped.
    pub body: &'f str,
    /// What it has beside the style of every page.
    pub style: &'f str,
    /// What runs after the script of every page.
    pub script: &'f str,
    /// What the scripts know.
    pub data: Value,
    /// Whether it may ask the program that it comes from.
    pub asks: bool,
}

/// A page with a script of its own, which puts fragments into its body.
pub fn application(frame: &Frame) -> String {
    let data = json!({ "ids": [], "tones": figure::tones(), "figures": [], "explore": frame.data });
    document(&Frame { title: frame.title.clone(), data, ..*frame })
}

/// What a page forbids itself: everything but its own script and style, which are named by their hashes.
pub fn policy(frame: &Frame) -> String {
    let (script, style) = (format!("{SCRIPT}{}", frame.script), format!("{STYLE}{}", frame.style));
    let asks = if frame.asks { "; connect-src 'self'" } else { "" };
    format!(
        "default-src 'none'; script-src '{}'; style-src '{}'; img-src data:; base-uri 'none'; form-action 'none'{asks}",
        hash_source(&script),
        hash_source(&style)
    )
}

fn document(frame: &Frame) -> String {
    let (title, data, policy) = (escaped(&frame.title), island(&frame.data), policy(frame));
    let Frame { body, style, script, .. } = frame;
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{policy}\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<meta name=\"referrer\" content=\"no-referrer\">\n\
         <meta name=\"generator\" content=\"gearwise {version}\">\n<link rel=\"icon\" href=\"data:,\">\n\
         <title>{title}</title>\n<style>{STYLE}{style}</style>\n</head>\n<body>\n{body}\
         <script type=\"application/json\" id=\"data\">{data}</script>\n<script>{SCRIPT}{script}</script>\n</body>\n</html>\n",
        version = env!("CARGO_PKG_VERSION"),
    )
}

/// Parts for a page that is open already: `html`, with the `ids` and the `figures` that its numbers mean. The page's script puts
/// them in the place of others (`mount`).
pub fn fragment(parts: &[Part]) -> Value {
    let (html, ids, figures) = written(|body| parts.iter().for_each(|part| body.part(part)));
    json!({ "html": html, "ids": ids.names(), "figures": figures })
}

/// What is written as a body, with its ids and figures.
fn written(write: impl FnOnce(&mut Body)) -> (String, Ids, Vec<Value>) {
    let mut ids = Ids::default();
    let mut figures: Vec<Value> = Vec::new();
    let mut body = Body { out: String::new(), ids: &mut ids, figures: &mut figures };
    write(&mut body);
    (body.out, ids, figures)
}

/// How a policy names an inline script or style: by its hash, in base 64.
fn hash_source(text: &str) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let hash = Sha256::hash(text.as_bytes());
    let mut out = String::from("sha256-");
    for chunk in hash.chunks(3) {
        let bits = chunk.iter().fold(0_u32, |bits, byte| bits << 8 | u32::from(*byte)) << (8 * (3 - chunk.len()));
        for k in 0..4 {
            let digit = char::from(DIGITS[(bits >> (18 - 6 * k)) as usize & 63]);
            out.push(if k <= chunk.len() { digit } else { '=' });
        }
    }
    out
}

/// JSON that no text in it can end: what HTML or an old script engine could stumble over is escaped.
fn island(value: &Value) -> String {
    let mut out = String::new();
    for c in value.to_string().chars() {
        match c {
            '<' | '>' | '&' | '\u{2028}' | '\u{2029}' => {
                let _ = write!(out, "\\u{:04x}", u32::from(c));
            }
            c if turns(c) => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

/// The body as it grows.
struct Body<'a> {
    out: String,
    ids: &'a mut Ids,
    figures: &'a mut Vec<Value>,
}

impl Body<'_> {
    /// Writes markup; every text in it must be escaped already.
    fn put(&mut self, markup: &str) {
        self.out.push_str(markup);
    }

    fn page(&mut self, page: &Page) {
        let (class, word) = match page.verdict {
            Verdict::Information => ("", ""),
            Verdict::Satisfied => ("good", "satisfied"),
            Verdict::NotSatisfied => ("bad", "not satisfied"),
        };
        let badge =
            if word.is_empty() { String::new() } else { format!(" <span class=\"badge {class}\">{word}</span>") };
        let (command, title) = (escaped(page.command), escaped(&page.title));
        self.put(&format!(
            "<a class=\"skip\" href=\"#main\">to the result</a>\n<header class=\"top\">\n\
             <h1><span class=\"kind\">{command}</span> {title}{badge}</h1>\n\
             <button type=\"button\" id=\"theme\">theme: as the system</button>\n</header>\n\
             <main id=\"main\">\n"
        ));
        if !page.asked.is_empty() {
            self.put(
                "<section id=\"asked\" aria-labelledby=\"asked-title\">\n<h2 id=\"asked-title\">What was asked</h2>\n",
            );
            for part in &page.asked {
                self.part(part);
            }
            self.put("</section>\n");
        }
        self.put(&format!(
            "<section id=\"summary\" aria-labelledby=\"summary-title\">\n\
             <h2 id=\"summary-title\">In short</h2>\n<p class=\"headline\">{}</p>\n",
            printed(&page.headline)
        ));
        for part in &page.summary {
            self.part(part);
        }
        if !page.warnings.is_empty() {
            let count = page.warnings.len();
            let word = if count == 1 { "thing" } else { "things" };
            self.put(&format!("<p><a href=\"#warnings\">{count} {word} to know before this is used</a></p>\n"));
        }
        self.put("</section>\n");
        self.contents(page);
        for (k, section) in page.sections.iter().enumerate() {
            self.section(k, section);
        }
        if !page.warnings.is_empty() {
            self.put(
                "<section id=\"warnings\" aria-labelledby=\"warnings-title\">\n\
                 <h2 id=\"warnings-title\">Warnings</h2>\n",
            );
            self.list(&page.warnings);
            self.put("</section>\n");
        }
        self.origin(page);
        self.put(
            "</main>\n<div id=\"chosen\" role=\"status\" hidden><span id=\"chosen-text\"></span> \
             <button type=\"button\" id=\"chosen-next\">next place</button> \
             <button type=\"button\" id=\"chosen-clear\">clear (Esc)</button></div>\n\
             <noscript><p class=\"note\">Without script the tables can be read; sorting, filtering and the figures need it.</p></noscript>\n",
        );
    }

    fn contents(&mut self, page: &Page) {
        if page.sections.len() < 2 {
            return;
        }
        self.put("<nav aria-label=\"sections\"><ul>");
        for (k, section) in page.sections.iter().enumerate() {
            self.put(&format!("<li><a href=\"#s{k}\">{}</a></li>", escaped(&section.title)));
        }
        if !page.warnings.is_empty() {
            self.put("<li><a href=\"#warnings\">Warnings</a></li>");
        }
        self.put("<li><a href=\"#origin\">Where this comes from</a></li></ul></nav>\n");
    }

    fn section(&mut self, k: usize, section: &Section) {
        let title = escaped(&section.title);
        self.put(&format!("<section id=\"s{k}\" aria-labelledby=\"t{k}\">\n<h2 id=\"t{k}\">{title}</h2>\n"));
        for part in &section.parts {
            match part {
                Part::Table(table) if table.caption == section.title => self.table(table, true),
                part => self.part(part),
            }
        }
        self.put("</section>\n");
    }

    fn part(&mut self, part: &Part) {
        match part {
            Part::Text(text) => self.put(&format!("<p>{}</p>\n", printed(text))),
            Part::List(lines) => self.list(lines),
            Part::Plain(text) => {
                // The escape makes blanks of line ends, so lines are escaped one by one.
                let lines: Vec<String> = text.lines().map(escaped).collect();
                self.put(&format!("<pre tabindex=\"0\">{}</pre>\n", lines.join("\n")));
            }
            Part::Table(table) => self.table(table, false),
            Part::Figure(figure) => {
                let k = self.figures.len();
                let data = figure::data(figure, self.ids);
                let name = escaped(data["title"].as_str().unwrap_or_default());
                let text = escaped(data["description"].as_str().unwrap_or_default());
                self.put(&format!(
                    "<figure class=\"figure\" data-figure=\"{k}\" aria-label=\"{name}\"><figcaption class=\"unseen\">{text}</figcaption></figure>\n"
                ));
                self.figures.push(data);
            }
            Part::Bars(bars) => self.put(&bars.html()),
            Part::Chain(chain) => self.put(&chain.html()),
            Part::Folded(title, part) => {
                self.put(&format!("<details><summary>{}</summary>\n", printed(title)));
                self.part(part);
                self.put("</details>\n");
            }
        }
    }

    fn list(&mut self, lines: &[String]) {
        self.put("<ul>");
        for line in lines {
            self.put(&format!("<li>{}</li>\n", printed(line)));
        }
        self.put("</ul>\n");
    }

    /// A table; its caption is only spoken where it stands above as a title already.
    fn table(&mut self, table: &Table, titled: bool) {
        // A column without a single entry says nothing.
        let used: Vec<bool> = (0..table.columns.len())
            .map(|k| table.rows.iter().any(|r| r.cells.get(k).is_some_and(|c| !c.is_empty())))
            .collect();
        let caption = printed(&table.caption);
        // Of the columns that say something, as many as were meant.
        let main = used.iter().take(table.main).filter(|used| **used).count();
        let all = used.iter().filter(|used| **used).count();
        let main = if main > 0 && main < all { format!(" data-main=\"{main}\"") } else { String::new() };
        let unseen = if titled { " class=\"unseen\"" } else { "" };
        self.put(&format!(
            "<div class=\"table\"{main}><div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"{caption}\">\n\
             <table><caption{unseen}>{caption}</caption>\n<thead><tr>"
        ));
        for (column, _) in table.columns.iter().zip(&used).filter(|(_, used)| **used) {
            let class = if column.number { " class=\"n\"" } else { "" };
            let unit = match column.unit.as_str() {
                "" => String::new(),
                unit => format!(" <small>{}</small>", escaped(unit)),
            };
            self.put(&format!("<th scope=\"col\"{class}>{}{unit}</th>", printed(&column.name)));
        }
        self.put("</tr></thead>\n<tbody>\n");
        for row in table.rows.iter().take(MOST_ROWS) {
            let class = if row.faint { " class=\"faint\"" } else { "" };
            let id = if row.id.is_empty() { String::new() } else { format!(" data-i={}", self.ids.index(&row.id)) };
            self.put(&format!("<tr{class}{id}>"));
            for (k, cell) in row.cells.iter().enumerate().filter(|(k, _)| used.get(*k) == Some(&true)) {
                // Which cells hold numbers the script sees from the header; the end of a cell goes without saying.
                self.put(if table.columns.get(k).is_some_and(|c| c.number) { "<td class=n>" } else { "<td>" });
                self.put(&printed(cell));
            }
            self.put("\n");
        }
        self.put("</tbody></table></div>");
        if table.rows.len() > MOST_ROWS {
            let left = table.rows.len() - MOST_ROWS;
            self.put(&format!("<p class=\"note\">{left} more rows are not on this page; --csv gives all.</p>"));
        }
        self.put("</div>\n");
    }

    /// What the result rests on, so that it can be made again.
    fn origin(&mut self, page: &Page) {
        self.put(
            "<section id=\"origin\" aria-labelledby=\"origin-title\">\n<h2 id=\"origin-title\">Where this comes from</h2>\n",
        );
        let version = env!("CARGO_PKG_VERSION");
        self.put(&format!("<p>gearwise {version}; the same input gives this page again, byte for byte.</p>\n"));
        if !page.call.is_empty() {
            self.put(&format!("<pre tabindex=\"0\">{}</pre>\n", escaped(&page.call)));
        }
        if !page.inputs.is_empty() {
            let rows = page.inputs.iter().map(|f| vec![f.name.clone(), f.sha256.clone()]);
            self.table(&Table::new("Input files", &["file", "sha256"]).rows(rows), false);
        }
        self.put("</section>\n");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::{Group, Mark, Series, Tone};

    #[test]
    fn a_fragment_is_what_a_page_has_of_the_same_parts() {
        let hostile = "</script><b>x";
        let mut table = Table::new("Motors", &["motor", ">loss [W]"]);
        table.push(hostile, vec![hostile.into(), "1".into()]);
        let series = Series {
            ids: vec![hostile.into()],
            ..Series::new(Tone::Blue, Mark::Points(plot::Shape::Circle), vec![(1.0, 2.0)])
        };
        let panel = plot::Panel {
            x: plot::Axis::linear("N"),
            y: plot::Axis::linear("loss"),
            series: vec![series],
            ..plot::Panel::default()
        };
        let figure =
            plot::Figure { groups: vec![Group { panels: vec![panel], ..Group::default() }], ..plot::Figure::default() };
        let parts = vec![Part::Text(hostile.into()), Part::Table(table), Part::Figure(figure)];
        let fragment = fragment(&parts);
        let html = fragment["html"].as_str().unwrap();
        assert!(!html.contains("</script>") && html.contains("&lt;/script&gt;"), "{html}");
        // One thing has one number, in table and figure.
        assert_eq!(fragment["ids"], json!([hostile]));
        assert!(html.contains("data-i=0") && html.contains("data-figure=\"0\""));
        assert_eq!(fragment["figures"][0]["groups"][0]["panels"][0]["series"][0]["ids"], json!([0]));
        let page = text(&Page { sections: vec![Section::new("All", parts)], ..Page::default() });
        assert!(page.contains(html));
    }
}
