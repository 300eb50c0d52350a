//! Columns of pairs, in CSV and TOML.

use super::*;
use crate::input::{Form, InputError};

const KINDS: [(&Kind, Range); 2] = [(&units::TORQUE, Range::Positive), (&units::TIME, Range::NonNegative)];

/// The pairs of a cell, or messages with what they mark.
type Pairs = Result<Option<Vec<[f64; 2]>>, Vec<(String, String)>>;

/// The pairs of the first row.
fn pairs(header: &str, cell: &str) -> Pairs {
    let text = format!("name,{header}\na,{cell}\n");
    let source = Arc::new(Source::new("a.csv", text.clone()));
    let column = |name: &str, content| Column { name: name.into(), content, required: false };
    let columns = vec![column("name", Content::Text), column("overload", Content::Pairs(KINDS))];
    let mut problems = Vec::new();
    let read = Table::read(&source, columns, &mut problems).and_then(|t| t.pairs(0, "overload", &mut problems));
    let said = |p: Problem| (p.message, text[p.span.unwrap()].to_string());
    if problems.is_empty() { Ok(read) } else { Err(problems.into_iter().map(said).collect()) }
}

#[test]
fn cells_of_pairs() {
    let good = Ok(Some(vec![[7.0, 120.0], [10.0, 18.0]]));
    assert_eq!(pairs("overload [N*m : s]", "7:120 10:18"), good);
    assert_eq!(pairs("overload [mN*m:min]", "\"7e3:2   10000:0.3\""), good);
    assert_eq!(pairs("overload [N*m : s]", "5:0"), Ok(Some(vec![[5.0, 0.0]])));
    assert_eq!(pairs("overload [N*m : s]", ""), Ok(None));
    let wrong = |cell: &str| pairs("overload [N*m : s]", cell).unwrap_err();
    assert_eq!(
        wrong("7:120 10-18 x:3"),
        [
            ("`overload`: `10-18` is not a pair".into(), "10-18".to_string()),
            ("`overload`: `x` is not a number (of at most 1e18 in SI units)".into(), "x:3".into()),
        ]
    );
    assert_eq!(wrong("-7:120")[0], ("`overload`: `-7` is out of range".into(), "-7:120".into()));
    assert_eq!(wrong("7:1:2")[0].1, "7:1:2");
    assert_eq!(wrong("7:")[0].1, "7:");
    assert_eq!(wrong("\"7:120, 10:18\"")[0].1, "7:120,");
}

#[test]
fn headers_of_pairs() {
    let said = |header: &str| pairs(header, "1:2").unwrap_err().remove(0).0;
    assert_eq!(said("overload"), "column `overload`: its cells are pairs, which have two units");
    assert_eq!(said("overload [N*m]"), "column `overload`: its cells are pairs, which have two units");
    assert_eq!(said("overload [N*m : m]"), "column `overload`: `m` is not a unit of time");
    assert_eq!(said("overload [ : s]"), "column `overload`: a torque needs its unit");
    assert_eq!(said("overload [N*m : s : s]"), "column `overload`: `: s` is not a unit");
    assert_eq!(said("overload [N*m : s],overload [N*m : s]"), "duplicate column `overload`");
}

#[test]
fn pairs_in_toml() {
    let read = |text: &str| {
        let source = Arc::new(Source::new("a.toml", format!("overload = {text}")));
        Form::read(&source, |root| root.pairs("overload", KINDS)).map_err(|e: InputError| {
            e.problems.into_iter().map(|p| (p.message, source.text()[p.span.unwrap()].to_string())).collect::<Vec<_>>()
        })
    };
    assert_eq!(read("[[\"7 N*m\", \"2 min\"], [\"10 N*m\", \"18 s\"]]").unwrap(), [[7.0, 120.0], [10.0, 18.0]]);
    assert_eq!(read("\"7:120\"").unwrap_err()[0].0, "`overload` is a string");
    let wrong = read("[[\"7 N*m\"], [\"10 N*m\", 18], [\"1 N*m\", \"-1 s\"]]").unwrap_err();
    assert_eq!(wrong[0], ("`overload` has something that is not a pair".into(), "[\"7 N*m\"]".to_string()));
    assert_eq!(wrong[1], ("`overload` has no unit".into(), "18".into()));
    assert_eq!(wrong[2], ("`overload` is out of range".into(), "\"-1 s\"".into()));
}

#[test]
fn rows_are_counted_before_they_are_held() {
    let text = |rows: usize, row: &str| format!("a\n{}", row.repeat(rows));
    assert!(oversized(&text(limits::TABLE_ROWS, "1\n")).is_none());
    let problem = oversized(&text(limits::TABLE_ROWS + 1, "1\n")).unwrap();
    assert_eq!(problem.span, None);
    assert!(oversized(&text(limits::TABLE_ROWS + 1, "1\r\n")).is_some());
    // Blank lines and comments are no rows.
    assert!(oversized(&text(limits::TABLE_ROWS + 1, "\n")).is_none());
    assert!(oversized(&text(limits::TABLE_ROWS + 1, "#\n")).is_none());
}
