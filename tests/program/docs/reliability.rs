//! The tables of docs/reliability.md are what the scripts that it names wrote: each stands below a line
//! `<!-- rows of FILE.csv -->` and must be that file. `INSTA_UPDATE=always` writes them.

use std::fs;

const PAGE: &str = "docs/reliability.md";

/// A CSV file as a Markdown table; lines that begin with `#` are no rows.
fn table(path: &str) -> String {
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .comment(Some(b'#'))
        .from_path(path)
        .unwrap_or_else(|error| panic!("{path}, named in {PAGE}: {error}"));
    let rows: Vec<csv::StringRecord> = reader.records().map(|r| r.expect("a row as long as the header")).collect();
    assert!(rows.len() > 1, "{path} has no rows");
    let line = |row: &csv::StringRecord| {
        format!("| {} |\n", row.iter().map(|c| c.replace('|', "\\|")).collect::<Vec<_>>().join(" | "))
    };
    let mut text = line(&rows[0]);
    text.push_str(&format!("|{}\n", " --- |".repeat(rows[0].len())));
    rows[1..].iter().for_each(|row| text.push_str(&line(row)));
    text
}

/// The page with every marked table made again, and how many there are.
fn made_again(page: &str) -> (String, usize) {
    let (mut out, mut tables) = (String::new(), 0);
    let mut lines = page.split_inclusive('\n').peekable();
    while let Some(line) = lines.next() {
        out.push_str(line);
        let Some(path) = line.trim().strip_prefix("<!-- rows of ").and_then(|l| l.strip_suffix(" -->")) else {
            continue;
        };
        while lines.next_if(|l| l.starts_with('|')).is_some() {}
        out.push_str(&table(path));
        tables += 1;
    }
    (out, tables)
}

#[test]
fn the_tables_are_what_the_scripts_wrote() {
    let page = fs::read_to_string(PAGE).expect("the page");
    let (again, tables) = made_again(&page);
    assert!(tables >= 3, "{tables} tables");
    if std::env::var("INSTA_UPDATE").is_ok_and(|v| v == "always") {
        fs::write(PAGE, &again).expect("the page can be written");
    } else {
        assert_eq!(
            page, again,
            "{PAGE} is not what the scripts wrote: INSTA_UPDATE=always cargo test --test program reliability"
        );
    }
}

#[test]
fn every_script_and_test_that_the_page_names_is_there() {
    let page = fs::read_to_string(PAGE).expect("the page");
    let named: Vec<&str> = page
        .split('`')
        .skip(1)
        .step_by(2)
        .map(|code| code.split_whitespace().next().unwrap_or(""))
        .filter(|path| path.contains('/') && !path.contains('*') && !path.contains("::"))
        .collect();
    assert!(named.len() > 5, "{named:?}");
    for path in named {
        assert!(fs::exists(path).unwrap_or(false), "{PAGE} names `{path}`, which is not there");
    }
}
