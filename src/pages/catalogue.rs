//! What the built-in catalogue has: by kind and maker, and of each column in how many rows.

use std::collections::BTreeMap;

use super::{MADE, table};
use crate::catalog::convention::word;
use crate::catalog::filter::text_of;
use crate::catalog::row::{Column, MotorRow, Row};
use crate::catalog::{Catalog, Gear, GearKind, Module, Motor};
use crate::words::number;

/// The page of the catalogue.
pub fn text() -> String {
    let catalog = match Catalog::builtin() {
        Ok(catalog) => catalog,
        Err(errors) => return errors.iter().map(ToString::to_string).collect(),
    };
    let gears: Vec<Gear> = catalog.gears.clone();
    let motors: Vec<MotorRow> = catalog.motors.iter().map(MotorRow::of).collect();
    let complete = catalog.motors.iter().filter(|m| is_complete(m)).count();
    let usable = catalog.motors.iter().filter(|m| m.rotor_inertia.is_some()).count();
    let points: usize = catalog.families.iter().map(|f| f.points.len()).sum();
    let lossless = gears.iter().filter(|g| g.efficiency.is_none()).count();
    let mut out = format!(
        "{MADE}# The built-in catalogue\n\n{} motors, {} gears, {} modules, and {} families of gears with {points} points. Where each number comes \
         from is in its row (`gearwise catalog show ID`), and [catalogs/SOURCES.md](../catalogs/SOURCES.md) says how sources were read.\n\n\
         A motor is *complete* where its row has R, K_T, rotor inertia, mass, outer diameter, and heat: both thermal resistances, or what it \
         gives continuously. {complete} are. {usable} have a rotor inertia: the others cannot be evaluated, unless it is \
         [estimated](estimates.md). {lossless} gears have no efficiency: they are listed and compared, and no choice by loss.\n\n## Motors\n\n",
        motors.len(),
        gears.len(),
        catalog.modules.len(),
        catalog.families.len()
    );
    let of = |rows: &[&Motor]| {
        vec![
            rows.len().to_string(),
            rows.iter().filter(|m| is_complete(m)).count().to_string(),
            range(rows.iter().filter_map(|m| m.mass.map(|v| v * 1e3))),
            range(rows.iter().map(|m| m.torque_constant / m.resistance.sqrt())),
        ]
    };
    let by = grouped(&catalog.motors, |m| m.manufacturer.clone());
    out.push_str(&table(&["maker", "rows", "complete", "mass [g]", "K_M [N·m/√W]"], lines(&by, of)));
    out.push_str("\n## Gears\n\n");
    let of = |rows: &[&Gear]| {
        vec![
            rows.len().to_string(),
            rows.iter().filter(|g| g.efficiency.is_some()).count().to_string(),
            range(rows.iter().map(|g| g.ratio)),
            range(rows.iter().filter_map(|g| g.peak_torque)),
            range(rows.iter().filter_map(|g| g.mass.map(|v| v * 1e3))),
        ]
    };
    let by = grouped(&gears, |g| format!("{}, {}", word(GearKind::NAMES, &g.kind).replace('_', " "), g.manufacturer));
    let header = ["kind, maker", "rows", "with efficiency", "ratio", "peak torque [N·m]", "mass [g]"];
    out.push_str(&table(&header, lines(&by, of)));
    out.push_str("\n## Modules\n\n");
    let of = |rows: &[&Module]| vec![rows.len().to_string(), range(rows.iter().map(|m| m.ratio()))];
    let by = grouped(&catalog.modules, |m| m.manufacturer.clone());
    out.push_str(&table(&["maker", "rows", "ratio"], lines(&by, of)));
    out.push_str(
        "\n## Columns\n\nIn how many rows each column is. What a lack prevents is printed by `gearwise audit`.\n",
    );
    for (name, all, columns) in [
        ("Motors", motors.len(), columns(&motors)),
        ("Gears", gears.len(), columns(&gears)),
        ("Modules", catalog.modules.len(), columns(&catalog.modules)),
    ] {
        out.push_str(&format!("\n### {name}\n\n"));
        let rows = columns.into_iter().map(|(column, rows)| {
            vec![format!("`{column}`"), rows.to_string(), format!("{:.0} %", 100.0 * rows as f64 / all.max(1) as f64)]
        });
        out.push_str(&table(&["column", "rows", "share"], rows));
    }
    out
}

fn is_complete(motor: &Motor) -> bool {
    let heat =
        motor.continuous_current.is_some() || motor.continuous_torque.is_some() || motor.thermal_resistance.is_some();
    let parts = [motor.rotor_inertia.is_some(), motor.mass.is_some(), motor.sheet.outer_diameter.is_some(), heat];
    parts.iter().all(|has| *has)
}

fn grouped<T>(rows: &[T], by: impl Fn(&T) -> String) -> BTreeMap<String, Vec<&T>> {
    let mut groups: BTreeMap<String, Vec<&T>> = BTreeMap::new();
    for row in rows {
        groups.entry(by(row)).or_default().push(row);
    }
    groups
}

fn lines<T>(groups: &BTreeMap<String, Vec<&T>>, of: impl Fn(&[&T]) -> Vec<String>) -> Vec<Vec<String>> {
    groups.iter().map(|(name, rows)| std::iter::once(name.clone()).chain(of(rows)).collect()).collect()
}

/// The least and the largest.
fn range(values: impl Iterator<Item = f64>) -> String {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    match low.total_cmp(&high) {
        std::cmp::Ordering::Less => format!("{} to {}", number(low), number(high)),
        std::cmp::Ordering::Equal => number(low),
        std::cmp::Ordering::Greater => "–".into(),
    }
}

/// Each column that may be blank, with the number of rows that have it.
fn columns<R: Row>(rows: &[R]) -> Vec<(&'static str, usize)> {
    let texts = |columns: &'static [Column<R>]| {
        columns
            .iter()
            .map(|c| (c.name, rows.iter().filter(|row| text_of(c, row).is_some()).count()))
            .collect::<Vec<_>>()
    };
    let numbers = R::fields().iter().map(|f| (f.name, rows.iter().filter(|r| (f.get)(r.numbers()).is_some()).count()));
    texts(R::BEFORE).into_iter().chain(numbers).chain(texts(R::AFTER)).collect()
}
