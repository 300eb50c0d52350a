//! Answers about a catalogue: `catalog list`, `search`, `show`, `diff` and `path` with `--json`.

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::document;
use super::motors::AuditRemark;
use crate::catalog::card::{Card, gear_lacks};
use crate::catalog::diff::counts;
use crate::catalog::list::Listing;
use crate::catalog::module::module_lacks;
use crate::catalog::path::{Places, User};
use gearwise_model::actuator::estimate::builtin_laws;
use gearwise_model::catalog::against::Against;
use gearwise_model::catalog::audit::Finding;
use gearwise_model::catalog::convention::{Winding, word};
use gearwise_model::catalog::difference::{Became, Cell, Change, Difference};
use gearwise_model::catalog::row::{Holds, MotorRow, Row as CatalogRow};
use gearwise_model::catalog::{Alternative, Family, Gear, GearKind, Module, Motor, SourceKind};

/// What `catalog list` and `catalog search` print.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Listed<'a> {
    /// The filters, as they were written.
    pub filters: Vec<&'a str>,
    /// Motors.
    pub motors: Vec<Row>,
    /// Gears.
    pub gears: Vec<Row>,
    /// Modules.
    pub modules: Vec<Row>,
    /// Families of gears.
    pub families: Vec<FamilyRow<'a>>,
    /// Rows that are not here because a number is not known that a filter asks for.
    pub unknown_rows: usize,
    /// Of each filter of which some row does not know the value.
    pub unknown: Vec<Unknown<'a>>,
    /// Names that may have been meant, where nothing was found.
    pub near: Vec<&'a str>,
}

/// How many rows do not know a column.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Unknown<'a> {
    /// The column.
    pub column: &'a str,
    /// In how many rows it is not known.
    pub rows: usize,
}

/// A row of a catalogue, as it is printed.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Row {
    /// Its id.
    pub id: String,
    /// Columns that are texts, but for the id.
    pub texts: Vec<Text>,
    /// Columns that are numbers.
    pub numbers: Vec<Number>,
    /// Columns that are curves or tables.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub pairs: Vec<Pairs>,
}

/// A column that is a curve or a table.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Pairs {
    /// The column.
    pub column: &'static str,
    /// SI units of the two numbers of a pair.
    pub unit: [&'static str; 2],
    /// The pairs, as printed.
    pub points: Vec<[f64; 2]>,
}

/// A column that is a text.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Text {
    /// The column.
    pub column: &'static str,
    /// What it says.
    pub value: String,
}

/// A column that is a number.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Number {
    /// The column.
    pub column: &'static str,
    /// The number as printed, SI, in the convention of the row.
    pub value: f64,
    /// Its SI unit; `1` for a pure number.
    pub unit: &'static str,
    /// Its ±, in the same unit.
    pub tolerance: Option<f64>,
    /// What it states of itself that its row does not: a convention.
    pub states: Option<&'static str>,
}

impl Row {
    fn of<R: CatalogRow>(row: &R) -> Row {
        let (mut texts, mut numbers, mut pairs, mut id) = (Vec::new(), Vec::new(), Vec::new(), String::new());
        for column in R::BEFORE.iter().chain(R::AFTER) {
            let value = match column.holds {
                Holds::Text(get, _) => get(row),
                Holds::Choice(_, get, _) => get(row).unwrap_or_default().to_string(),
                Holds::Pairs([(first, _), (second, _)], get, _) => {
                    let unit = [first.si, second.si];
                    pairs.extend(Some(get(row)).filter(|p| !p.is_empty()).map(|points| Pairs {
                        column: column.name,
                        unit,
                        points,
                    }));
                    continue;
                }
                Holds::Count(get, _) => {
                    let (column, unit) = (column.name, "1");
                    let number =
                        |count| Number { column, value: f64::from(count), unit, tolerance: None, states: None };
                    numbers.extend(get(row).map(number));
                    continue;
                }
            };
            match column.name {
                "id" => id = value,
                _ if value.is_empty() => {}
                column => texts.push(Text { column, value }),
            }
        }
        for field in R::fields() {
            let Some(printed) = (field.get)(row.numbers()) else { continue };
            numbers.push(Number {
                column: field.name,
                value: printed.value,
                unit: field.kind.si,
                tolerance: printed.tolerance,
                states: row.states(field).convention,
            });
        }
        Row { id, texts, numbers, pairs }
    }

    fn of_motor(motor: &Motor) -> Row {
        Row::of(&MotorRow::of(motor))
    }
}

fn listing<'a>(of: &'a Listing) -> Listed<'a> {
    let unknown = of.found.unknown_by.iter().map(|(column, rows)| Unknown { column, rows: *rows });
    Listed {
        filters: of.filters.iter().map(|f| f.text.as_str()).collect(),
        motors: of.found.motors.iter().map(|m| Row::of_motor(m)).collect(),
        gears: of.found.gears.iter().map(|g| Row::of(*g)).collect(),
        modules: of.found.modules.iter().map(|m| Row::of(*m)).collect(),
        families: of.found.families.iter().map(|family| FamilyRow::of(family)).collect(),
        unknown_rows: of.found.unknown,
        unknown: unknown.collect(),
        near: of.near.clone(),
    }
}

/// What was listed.
pub fn listed(of: &Listing) -> Value {
    document("catalog list", listing(of))
}

/// What a search found.
pub fn searched(of: &Listing) -> Value {
    document("catalog search", listing(of))
}

/// A family of gears.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct FamilyRow<'a> {
    /// Its name.
    pub name: &'a str,
    /// How its gears reduce.
    pub kind: &'static str,
    /// Number of their stages.
    pub stages: Option<u32>,
    /// Patterns of the motors that it is made for; empty for any.
    pub made_for: &'a [String],
    /// What its teeth are made of.
    pub material: &'a str,
    /// The largest stress in a tooth that all points are made for.
    pub stress_limit_pa: Option<f64>,
    /// Where the numbers come from.
    pub source: &'a str,
    /// What kind of source that is.
    pub source_kind: &'static str,
    /// What its reader should know.
    pub note: &'a str,
    /// Its gears by rising ratio, without the motor's part of mass and length.
    pub points: Vec<Row>,
}

impl<'a> FamilyRow<'a> {
    fn of(family: &'a Family) -> FamilyRow<'a> {
        let gear = &family.gear;
        FamilyRow {
            name: &family.name,
            kind: word(GearKind::NAMES, &gear.kind),
            stages: gear.stages,
            made_for: &gear.fits,
            material: &family.material,
            stress_limit_pa: family.stress_limit,
            source: &gear.source,
            source_kind: word(SourceKind::NAMES, &gear.source_kind),
            note: &gear.note,
            points: family.points.iter().map(Row::of).collect(),
        }
    }
}

/// A family of gears.
pub fn family_shown(family: &Family) -> Value {
    let shown = Shown {
        kind: "gear family",
        row: Row { id: family.name.clone(), texts: Vec::new(), numbers: Vec::new(), pairs: Vec::new() },
        family: Some(FamilyRow::of(family)),
        conventions: Vec::new(),
        heat: None,
        lacks: Vec::new(),
        same_motor: Vec::new(),
        assumptions: Vec::new(),
        audit: Vec::new(),
        alternatives: Vec::new(),
    };
    document("catalog show", shown)
}

/// What `catalog show` prints.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Shown<'a> {
    /// `motor`, `gear`, `module` or `gear family`.
    pub kind: &'static str,
    /// The row; of a family its name alone.
    pub row: Row,
    /// The family, where it is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub family: Option<FamilyRow<'a>>,
    /// Numbers in every convention that they have.
    pub conventions: Vec<InConvention>,
    /// How heat can be judged: `known`, `estimated` or `unknown`; `null` of a gear.
    pub heat: Option<&'static str>,
    /// What the row lacks.
    pub lacks: Vec<Lacking<'a>>,
    /// Other rows of the same motor.
    pub same_motor: Vec<&'a str>,
    /// What was assumed of the row.
    pub assumptions: Vec<&'a str>,
    /// What the audit found.
    pub audit: Vec<AuditRemark>,
    /// What other sources say of its numbers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub alternatives: Vec<Published<'a>>,
}

/// A number in a convention.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct InConvention {
    /// The column.
    pub column: &'static str,
    /// The convention.
    pub convention: &'static str,
    /// The windings that it is for, where the row does not say how they are connected.
    pub winding: Option<&'static str>,
    /// The number, SI.
    pub value: f64,
    /// Its SI unit.
    pub unit: &'static str,
    /// Whether the row gives it so.
    pub printed: bool,
}

/// Something that a row lacks.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Lacking<'a> {
    /// What.
    pub lacks: &'a str,
    /// What that prevents, were it not estimated.
    pub prevents: &'a str,
    /// What fills it.
    pub estimate: Option<Estimated>,
}

/// An estimate.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Estimated {
    /// The pessimistic end of its prediction interval (90 %, one-sided), which the model computes with.
    pub value: f64,
    /// Its middle.
    pub middle: f64,
    /// SI unit of both.
    pub unit: &'static str,
    /// The law.
    pub law: Option<String>,
    /// Rows that the law is made from.
    pub rows: usize,
}

/// A motor's card.
pub fn motor_shown(card: &Card, elsewhere: &[&Alternative]) -> Value {
    let lacks = card.lacks.iter().map(|(lack, estimate)| Lacking {
        lacks: lack.name,
        prevents: lack.prevents,
        estimate: estimate.map(|e| Estimated {
            value: e.value,
            middle: e.middle,
            unit: e.of.unit(),
            law: builtin_laws().iter().find(|l| l.of == e.of && l.construction == e.construction).map(|l| l.formula()),
            rows: e.rows,
        }),
    });
    let conventions = card.in_conventions().into_iter().map(|s| InConvention {
        column: s.column,
        convention: s.convention,
        winding: s.winding.map(|w| word(Winding::NAMES, &w)),
        value: s.value,
        unit: s.unit,
        printed: s.printed,
    });
    let shown = Shown {
        kind: "motor",
        row: Row::of_motor(card.motor),
        family: None,
        conventions: conventions.collect(),
        heat: Some(card.heat.word()),
        lacks: lacks.collect(),
        same_motor: card.twins.clone(),
        assumptions: card.motor.assumptions.clone(),
        audit: card.findings.iter().cloned().map(AuditRemark::from).collect(),
        alternatives: published(elsewhere),
    };
    document("catalog show", shown)
}

/// A gear's card.
pub fn gear_shown(gear: &Gear, elsewhere: &[&Alternative]) -> Value {
    let lacks =
        gear_lacks(gear).into_iter().map(|(lacks, prevents)| Lacking { lacks, prevents, estimate: None }).collect();
    let shown = Shown {
        kind: "gear",
        row: Row::of(gear),
        family: None,
        conventions: Vec::new(),
        heat: None,
        lacks,
        same_motor: Vec::new(),
        assumptions: Vec::new(),
        audit: Vec::new(),
        alternatives: published(elsewhere),
    };
    document("catalog show", shown)
}

/// A module's card.
pub fn module_shown(module: &Module, audit: &[Finding], elsewhere: &[&Alternative]) -> Value {
    let lacks = module_lacks(module).into_iter().map(|(lacks, prevents)| Lacking { lacks, prevents, estimate: None });
    let shown = Shown {
        kind: "module",
        row: Row::of(module),
        family: None,
        conventions: Vec::new(),
        heat: None,
        lacks: lacks.collect(),
        same_motor: Vec::new(),
        assumptions: Vec::new(),
        audit: audit.iter().cloned().map(AuditRemark::from).collect(),
        alternatives: published(elsewhere),
    };
    document("catalog show", shown)
}

/// What another source says of a number of a row.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Published<'a> {
    /// The column.
    pub column: &'static str,
    /// As printed, with its unit.
    pub printed: &'a str,
    /// The number, SI, at the side and in the convention that it says; `null` of curves, tables and counts.
    pub value: Option<f64>,
    /// Its ±, in the same unit.
    pub tolerance: Option<f64>,
    /// Its SI unit; `1` for a pure number.
    pub unit: &'static str,
    /// At which side of the gear it is, where it is said.
    pub side: Option<&'static str>,
    /// The word of its convention, where it is said.
    pub convention: Option<&'static str>,
    /// Where it is from.
    pub source: &'a str,
    /// The day of the source.
    pub source_date: &'a str,
    /// What kind of source that is.
    pub source_kind: &'static str,
    /// What the reader should know.
    pub note: &'a str,
}

fn published<'a>(elsewhere: &[&'a Alternative]) -> Vec<Published<'a>> {
    let one = |a: &&'a Alternative| Published {
        column: a.column,
        printed: &a.text,
        value: a.value.map(|v| v.value),
        tolerance: a.value.and_then(|v| v.tolerance),
        unit: a.unit,
        side: a.side.map(|side| side.word()),
        convention: a.convention,
        source: &a.source,
        source_date: &a.source_date,
        source_kind: word(SourceKind::NAMES, &a.source_kind),
        note: &a.note,
    };
    elsewhere.iter().map(one).collect()
}

/// What `catalog diff` prints.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Differ<'a> {
    /// Rows that the second catalogue alone has.
    pub added: usize,
    /// Rows that the first alone has.
    pub removed: usize,
    /// Rows that both have and that are not the same.
    pub changed: usize,
    /// Each of them.
    pub rows: Vec<DifferentRow<'a>>,
}

/// A row that is not the same.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct DifferentRow<'a> {
    /// `motor`, `gear` or `module`.
    pub kind: &'static str,
    /// Its id.
    pub id: &'a str,
    /// `added`, `removed` or `changed`.
    pub became: &'static str,
    /// The columns that are not the same; none of a row that one catalogue alone has.
    pub changes: Vec<DifferentCell<'a>>,
}

/// A column that is not the same.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct DifferentCell<'a> {
    /// The column.
    pub column: &'static str,
    /// SI unit of its numbers; `null` of a text.
    pub unit: Option<&'static str>,
    /// In the first catalogue; `null` is blank.
    pub before: Option<Side<'a>>,
    /// In the second.
    pub after: Option<Side<'a>>,
}

/// What a cell says.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Side<'a> {
    /// A text.
    pub text: Option<&'a str>,
    /// A number, SI.
    pub value: Option<f64>,
    /// Its ±.
    pub tolerance: Option<f64>,
    /// What it states of itself: a convention.
    pub states: Option<&'static str>,
}

impl<'a> Side<'a> {
    fn of(cell: &'a Cell) -> Side<'a> {
        match cell {
            Cell::Text(text) => Side { text: Some(text), value: None, tolerance: None, states: None },
            Cell::Number { printed, stated, .. } => {
                Side { text: None, value: Some(printed.value), tolerance: printed.tolerance, states: stated.convention }
            }
        }
    }
}

fn cell_of(change: &Change) -> DifferentCell<'_> {
    let unit = [&change.before, &change.after].into_iter().find_map(|cell| match cell {
        Some(Cell::Number { kind, .. }) => Some(kind.si),
        _ => None,
    });
    DifferentCell {
        column: change.column,
        unit,
        before: change.before.as_ref().map(Side::of),
        after: change.after.as_ref().map(Side::of),
    }
}

/// What is not the same in two catalogues.
pub fn differ(differences: &[Difference]) -> Value {
    let [added, removed, changed] = counts(differences);
    document("catalog diff", Differ { added, removed, changed, rows: differences.iter().map(different).collect() })
}

fn different(difference: &Difference) -> DifferentRow<'_> {
    let (became, changes) = match &difference.became {
        Became::Added => ("added", Vec::new()),
        Became::Removed => ("removed", Vec::new()),
        Became::Changed(changes) => ("changed", changes.iter().map(cell_of).collect()),
    };
    DifferentRow { kind: difference.kind, id: &difference.id, became, changes }
}

/// What `audit --against` prints.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Compared<'a> {
    /// Rows that both have.
    pub both: usize,
    /// Rows that the catalogue alone has.
    pub own: usize,
    /// Rows that the second source alone has.
    pub second: usize,
    /// Numbers that both give with the same meaning; of none the command's exit status is 1.
    pub compared: usize,
    /// Numbers that are more than 1 % apart, row by row: `before` is ours, `after` that of the second source.
    pub apart: Vec<DifferentRow<'a>>,
    /// Numbers that one of them lacks.
    pub lacking: Vec<DifferentRow<'a>>,
    /// Rows of which ampere, terminals or winding mean something else in the two: their electrical numbers are not compared.
    pub conventions: &'a [String],
}

/// A catalogue against a second source.
pub fn compared(found: &Against) -> Value {
    let answer = Compared {
        both: found.both,
        own: found.own,
        second: found.second,
        compared: found.compared,
        apart: found.apart.iter().map(different).collect(),
        lacking: found.lacking.iter().map(different).collect(),
        conventions: &found.conventions,
    };
    document("audit against", answer)
}

/// What `catalog path` prints.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Paths {
    /// Where `user` is looked for.
    pub user: UserPlace,
    /// The built-in catalogue.
    pub builtin: BuiltinPlace,
}

/// Where `user` is looked for.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct UserPlace {
    /// The path.
    pub path: String,
    /// Whether `$GEARWISE_CATALOG` says so.
    pub by_variable: bool,
    /// `absent`, `read` or `wrong` (it has mistakes).
    pub state: &'static str,
    /// Its motors; `null` where it was not read.
    pub motors: Option<usize>,
    /// Its gears.
    pub gears: Option<usize>,
    /// Its modules.
    pub modules: Option<usize>,
}

/// The built-in catalogue.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct BuiltinPlace {
    /// Its motors.
    pub motors: usize,
    /// Its gears.
    pub gears: usize,
    /// Its modules.
    pub modules: usize,
    /// Files that it was made of.
    pub files: usize,
    /// The SHA-256 of all of them.
    pub sha256: String,
}

/// Where catalogues are.
pub fn paths(places: &Places) -> Value {
    let (state, read) = match places.found {
        User::Absent => ("absent", None),
        User::Read(rows) => ("read", Some(rows)),
        User::Wrong(_) => ("wrong", None),
    };
    let of = |kind: usize| read.map(|rows| rows[kind]);
    let path = places.user.display().to_string();
    let user = UserPlace { path, by_variable: places.by_variable, state, motors: of(0), gears: of(1), modules: of(2) };
    let [motors, gears, modules] = places.builtin;
    let builtin = BuiltinPlace { motors, gears, modules, files: places.files, sha256: places.sha256.clone() };
    document("catalog path", Paths { user, builtin })
}
