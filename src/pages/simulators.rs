//! The page of what each format of a simulator says of an actuator.

use super::{MADE, code, table};
use crate::design::simulated::Fact;
use crate::report::export::{Cell, FORMATS, Format};

pub fn text() -> String {
    let mut out = String::from(MADE);
    out.push_str("# What each simulator says of an actuator\n\n");
    out.push_str(
        "With this page you can see what `gearwise export --to FORMAT` says in each format, what only nearly, and what not at all; the same \
         is in the comments of what it writes. How to use it is in [Send a design to a simulator](simulators.md).\n\n\
         ✓ said, ~ nearly, – not sayable.\n\n",
    );
    out.push_str(&matrix());
    out.push_str(
        "\nEvery line of torque over speed is `max(−e, s (−1 − ω/ω₀)) ≤ τ ≤ min(e, s (1 − ω/ω₀))` at the joint: e is the largest torque of \
         motor, drive and gear, ω₀ the speed at which the voltage leaves no torque, and s makes the line pass the corner up to which the \
         voltage suffices for e, with the winding at its hottest.\n",
    );
    FORMATS.iter().for_each(|format| out.push_str(&one(format)));
    out
}

/// Facts down, formats across.
fn matrix() -> String {
    let header: Vec<&str> = std::iter::once("").chain(FORMATS.iter().map(|f| f.name)).collect();
    let row = |fact: &Fact| {
        let marks = FORMATS.iter().map(|f| (f.says)(*fact).mark().to_string());
        std::iter::once(fact.title().to_string()).chain(marks).collect()
    };
    table(&header, Fact::ALL.iter().map(row))
}

fn one(format: &Format) -> String {
    let word = |cell: Cell| match cell {
        Cell::Said(_) => "said",
        Cell::Approximately(_) => "nearly",
        Cell::Not(_) => "not",
    };
    let rows = Fact::ALL.iter().map(|fact| {
        let cell = (format.says)(*fact);
        vec![fact.title().to_string(), word(cell).into(), cell.words().into()]
    });
    let options = format.takes.iter().map(|wish| code(wish.option())).collect::<Vec<_>>().join(", ");
    let options = if options.is_empty() { String::new() } else { format!(" Options: {options}.") };
    format!(
        "\n## {}\n\n{}.{options} Names and units: <{}>. Checked against: {}.\n\n{}",
        format.name,
        format.about,
        format.source.replace(", ", ">, <"),
        format.checked,
        table(&["quantity", "", "key, way or reason"], rows)
    )
}
