//! The lock of a design: every value of every catalogue row that it uses, so that a change of the catalogue is
//! a decision and no accident.
//!
//! Numbers are kept as the row prints them, in SI, as text that reads back as the same number: two rows are
//! equal where their texts are.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use gearwise_model::catalog::convention::word;
use gearwise_model::catalog::{
    Catalog, ContinuousTorque, FIELDS, GEAR_FIELDS, Gear, GearField, GearKind, LifeQuantile, Motor, PeakTorqueOf,
    SourceKind,
};
use gearwise_model::input::kind::{self, FileKind};
use gearwise_model::input::{Form, InputError, Problem, Section, Source, sha256};
use gearwise_model::requirement::{Choice, DesignFile};

/// Version of the lock's form.
const VERSION: u32 = 1;

/// Motor or gear.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum RowKind {
    /// A motor.
    Motor,
    /// A gear.
    Gear,
}

impl RowKind {
    fn name(self) -> &'static str {
        match self {
            RowKind::Motor => "motor",
            RowKind::Gear => "gear",
        }
    }
}

/// A row with all its values.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Motor or gear.
    pub kind: RowKind,
    /// Its id.
    pub id: String,
    /// Column and value, in the order of the columns' names.
    pub values: Vec<(String, String)>,
}

/// What a lock file holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Lock {
    /// Name of the robot.
    pub robot: String,
    /// File name of the design.
    pub design: String,
    /// The rows, motors first, each kind by id.
    pub rows: Vec<Row>,
}

/// One difference between lock and catalogue.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// The row, and the column where one is meant.
    pub subject: String,
    /// What changed from what to what.
    pub message: String,
    /// Joints that use the row.
    pub used_by: Vec<String>,
    /// Whether it is the row of a gear.
    pub gear: bool,
}

/// How a design stands with its lock.
#[derive(Debug, Clone, PartialEq)]
pub enum LockState {
    /// There is none; where it would be.
    Missing(PathBuf),
    /// It was compared.
    Compared {
        /// The lock file.
        path: PathBuf,
        /// What differs.
        differences: Vec<Difference>,
    },
}

/// Where the lock of a design is: beside it, with the ending `.lock`.
pub fn path_of(design: &Path) -> PathBuf {
    design.with_extension("lock")
}

impl Row {
    /// SHA-256 over all columns and values, in hexadecimal.
    pub fn sha256(&self) -> String {
        // Lengths keep ("ab", "c") and ("a", "bc") apart.
        let line = |(name, value): &(String, String)| format!("{}:{name}={}:{value}\n", name.len(), value.len());
        sha256([self.values.iter().map(line).collect::<String>().as_bytes()])
    }

    fn sorted(kind: RowKind, id: &str, mut values: Vec<(String, String)>) -> Row {
        values.retain(|(_, value)| !value.is_empty());
        values.sort();
        Row { kind, id: id.into(), values }
    }

    /// Every value of a motor's row.
    pub fn of_motor(motor: &Motor) -> Row {
        let mut values = Vec::new();
        let mut add = |name: &str, value: String| values.push((name.to_string(), value));
        for field in FIELDS {
            if let Some(printed) = (field.get)(&motor.sheet) {
                add(field.name, with_unit(printed.value, field.kind.si));
                if let Some(tolerance) = printed.tolerance {
                    add(&format!("{}_tolerance", field.name), with_unit(tolerance, field.kind.si));
                }
            }
        }
        let conventions = &motor.conventions;
        add("manufacturer", motor.manufacturer.clone());
        add("model", motor.model.clone());
        add("source", motor.source.clone());
        add("source_kind", word(SourceKind::NAMES, &motor.source_kind).into());
        add("audit_accept", motor.accepted_findings.join(" "));
        add("price_currency", motor.sheet.offer.price_currency.clone());
        add("price_date", motor.sheet.offer.price_date.clone());
        // The conventions decide what the numbers mean.
        add("conventions", gearwise_model::catalog::audit::conventions_line(motor));
        add("commutation", format!("{:?}", conventions.commutation).to_lowercase());
        add("pole_pairs", motor.pole_pairs.map_or(String::new(), |p| p.to_string()));
        if let Some(of) = &motor.about.peak_torque_of {
            add("peak_torque_of", word(PeakTorqueOf::NAMES, of).into());
        }
        for effect in &motor.effects {
            for (parameter, value) in effect.effect.parameters().iter().zip(&effect.values) {
                add(&format!("effects.{}.{}", effect.name(), parameter.name), value.to_string());
            }
        }
        if let Some(gear) = motor.fitted_gear {
            add("fitted_gear", format!("{gear:?}"));
        }
        Row::sorted(RowKind::Motor, &motor.id, values)
    }

    /// Every value of a gear's row; of a point of a family with what that says of all.
    pub fn of_gear(gear: &Gear, catalog: &Catalog) -> Row {
        let stages = gear.stages.map(|stages| ("stages".to_string(), stages.to_string()));
        let number = |f: &GearField| Some((f.name.to_string(), with_unit((f.get)(gear)?.value, f.kind.si)));
        let texts = [
            ("manufacturer", gear.manufacturer.clone()),
            ("model", gear.model.clone()),
            ("kind", word(GearKind::NAMES, &gear.kind).into()),
            ("fits", gear.fits.join(" ")),
            ("price_currency", gear.offer.price_currency.clone()),
            ("price_date", gear.offer.price_date.clone()),
            ("source", gear.source.clone()),
            ("source_kind", word(SourceKind::NAMES, &gear.source_kind).into()),
        ];
        let of_life = gear.ratings.life_quantile.map(|q| ("life_quantile", word(LifeQuantile::NAMES, &q)));
        let of_torque =
            gear.ratings.continuous_torque_is.map(|is| ("continuous_torque_is", word(ContinuousTorque::NAMES, &is)));
        let words = of_life.into_iter().chain(of_torque).map(|(name, word)| (name.to_string(), word.to_string()));
        let numbers = GEAR_FIELDS.iter().filter_map(number).chain(stages).chain(words);
        let family = catalog.families.iter().find(|family| family.name == gear.family);
        let of_family = family.into_iter().flat_map(|family| {
            let stress = family.stress_limit.map(|stress| with_unit(stress, "Pa")).unwrap_or_default();
            [("material".to_string(), family.material.clone()), ("stress_limit".to_string(), stress)]
        });
        let values = numbers.chain(of_family).chain(texts.map(|(name, value)| (name.to_string(), value))).collect();
        Row::sorted(RowKind::Gear, &gear.id, values)
    }
}

fn with_unit(value: f64, unit: &str) -> String {
    if unit == "1" { value.to_string() } else { format!("{value:?} {unit}") }
}

impl Lock {
    /// The lock of a design as the catalogue is now.
    pub fn of(design: &DesignFile, choices: &[Choice], catalog: &Catalog) -> Lock {
        let motors = choices.iter().map(|c| Row::of_motor(c.motor));
        let mut rows: Vec<Row> =
            motors.chain(choices.iter().flat_map(Choice::gears).map(|gear| Row::of_gear(gear, catalog))).collect();
        rows.sort_by(|a, b| (a.kind, &a.id).cmp(&(b.kind, &b.id)));
        rows.dedup();
        Lock { robot: design.robot.name.clone(), design: file_name(design), rows }
    }

    /// The file's text.
    pub fn to_toml(&self) -> String {
        let quoted = |text: &str| toml::Value::String(text.into()).to_string();
        let mut out = String::from(
            "# The catalogue rows that the design uses, written by `gearwise check`. Commit it; renew it with --update-lock.\n",
        );
        let _ =
            write!(out, "version = {VERSION}\nrobot = {}\ndesign = {}\n", quoted(&self.robot), quoted(&self.design));
        for row in &self.rows {
            let kind = row.kind.name();
            let _ =
                write!(out, "\n[[{kind}]]\nid = {}\nsha256 = \"{}\"\n[{kind}.values]\n", quoted(&row.id), row.sha256());
            for (name, value) in &row.values {
                let bare = name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
                let name = if bare { name.clone() } else { quoted(name) };
                let _ = writeln!(out, "{name} = {}", quoted(value));
            }
        }
        out
    }

    /// Reads the lock of a design.
    ///
    /// # Errors
    /// All mistakes of the file; that it is the lock of another design.
    pub fn read(source: &Arc<Source>, design: &DesignFile) -> Result<Lock, InputError> {
        Form::read(source, |root| {
            let version = root.count("version");
            if !root.has("version") {
                root.missing("version", "1");
            } else if version.is_some_and(|v| v != VERSION) {
                let message = "the lock was written by another version of gearwise";
                root.note(
                    Problem::at(root.span_of("version"), message, format!("expected {VERSION}"))
                        .help("write it again with --update-lock"),
                );
            }
            let robot = root.required_text("robot", "\"quadruped\"");
            let of_design = root.required_text("design", "\"design.toml\"");
            let is = [("robot", &robot, design.robot.name.clone()), ("design", &of_design, file_name(design))];
            for (what, locked, now) in is {
                if let Some(locked) = locked.as_ref().filter(|locked| *locked.get_ref() != now) {
                    let message = format!("this is the lock of another {what}: `{}`", locked.get_ref());
                    root.note(
                        Problem::at(locked.span(), message, format!("the {what} checked is `{now}`"))
                            .help("if it was renamed, write the lock again with --update-lock"),
                    );
                }
            }
            let motors = root.sections("motor").into_iter().filter_map(|s| read_row(s, RowKind::Motor));
            let gears = root.sections("gear").into_iter().filter_map(|s| read_row(s, RowKind::Gear));
            let rows = motors.chain(gears).collect();
            Some(Lock { robot: robot?.into_inner(), design: of_design?.into_inner(), rows })
        })
        .map_err(|error| kind::instead(error, &[FileKind::Lock]))
    }

    /// What differs between this lock and another, newer one.
    pub fn differences(&self, now: &Lock, choices: &[Choice]) -> Vec<Difference> {
        let mut found = Vec::new();
        let used_by = |row: &Row| -> Vec<String> {
            let uses = |c: &&Choice| match row.kind {
                RowKind::Motor => c.motor.id == row.id,
                RowKind::Gear => c.gears().any(|g| g.id == row.id),
            };
            choices.iter().filter(uses).map(|c| c.design.name.clone()).collect()
        };
        let find = |lock: &'_ Lock, row: &Row| lock.rows.iter().position(|r| r.kind == row.kind && r.id == row.id);
        for row in &now.rows {
            let (used_by, gear) = (used_by(row), row.kind == RowKind::Gear);
            let kind = row.kind.name();
            let Some(locked) = find(self, row).map(|k| &self.rows[k]) else {
                let message = format!("{kind} {} is not in the lock", row.id);
                found.push(Difference { subject: row.id.clone(), message, used_by, gear });
                continue;
            };
            let value = |row: &Row, name: &str| row.values.iter().find(|(n, _)| n == name).map(|(_, v)| v.clone());
            let mut names: Vec<&String> = row.values.iter().chain(&locked.values).map(|(name, _)| name).collect();
            names.sort();
            names.dedup();
            for name in names {
                let (was, is) = (value(locked, name), value(row, name));
                if was == is {
                    continue;
                }
                let say = |v: Option<String>| v.unwrap_or_else(|| "not known".into());
                let message = format!("{kind} {} has changed: {name} was {}, is {}", row.id, say(was), say(is));
                found.push(Difference {
                    subject: format!("{}.{name}", row.id),
                    message,
                    used_by: used_by.clone(),
                    gear,
                });
            }
        }
        for row in self.rows.iter().filter(|row| find(now, row).is_none()) {
            let message = format!("{} {} is in the lock, but the design does not use it", row.kind.name(), row.id);
            let gear = row.kind == RowKind::Gear;
            found.push(Difference { subject: row.id.clone(), message, used_by: Vec::new(), gear });
        }
        found
    }
}

fn file_name(design: &DesignFile) -> String {
    let name = Path::new(design.source.name()).file_name();
    name.map_or_else(|| design.source.name().to_string(), |n| n.to_string_lossy().into_owned())
}

fn read_row(section: Section, kind: RowKind) -> Option<Row> {
    let id = section.required_text("id", "\"t-motor-ri50\"");
    let sha256 = section.required_text("sha256", "\"…\"");
    if !section.has("values") {
        section.missing("values", "{ … }");
    }
    let entries = section.entries("values");
    let values = entries.into_iter().map(|(name, value)| (name.into_inner(), value.into_inner())).collect();
    let row = id.map(|id| Row::sorted(kind, id.get_ref(), values));
    if let (Some(row), Some(sha256)) = (&row, sha256)
        && *sha256.get_ref() != row.sha256()
    {
        let message = format!("the values of {} {} do not belong to this hash", kind.name(), row.id);
        section.note(
            Problem::at(sha256.span(), message, "the lock was changed by hand, or merged badly")
                .help("write it again with --update-lock"),
        );
    }
    section.finish();
    row
}
