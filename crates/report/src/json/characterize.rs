//! `characterize --json`.

#[cfg(feature = "schema")]
use std::borrow::Cow;

#[cfg(feature = "schema")]
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use serde_json::Value;

#[cfg(feature = "schema")]
use super::number_or_null;
use super::{document, finite};
use gearwise_identify::Bench;
use gearwise_identify::characterize::estimate::Estimate as EstimateFact;
use gearwise_identify::characterize::row::Row as RowFact;
use gearwise_identify::characterize::{self as fact, Characterization};
use gearwise_model::catalog::convention::{Commutation, Winding, word};
use gearwise_model::catalog::{FIELDS, Field, Sheet};

/// What `characterize` prints.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Answer<'a> {
    /// Name of the bench.
    pub bench: &'a str,
    /// Ratio between motor and output.
    pub ratio: f64,
    /// Each test that the bench has.
    pub tests: Vec<Test<'a>>,
    /// What only several tests together say.
    pub findings: Vec<Finding<'a>>,
    /// The catalogue row that they make.
    pub row: Row<'a>,
    /// The logs.
    pub logs: Vec<Log<'a>>,
}

/// What one test found.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Test<'a> {
    /// Its name.
    pub test: &'a str,
    /// How it was done.
    pub method: &'a [String],
    /// What it found.
    pub quantities: Vec<Quantity<'a>>,
    /// What each log gave.
    pub logs: Vec<OfLog<'a>>,
    /// What its own checks say.
    pub findings: Vec<Finding<'a>>,
}

/// A number that a test found.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Quantity<'a> {
    /// Its name: the column of a catalogue row, where there is one.
    pub name: &'a str,
    #[serde(flatten)]
    estimate: Estimate,
    /// What should be known of it.
    pub remark: &'a str,
}

/// A number with its uncertainty, at the motor and on the q axis unless the name says otherwise.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Estimate {
    /// The number.
    pub value: Option<f64>,
    /// Its unit.
    pub unit: &'static str,
    /// Standard uncertainty; `null` where it is not known.
    pub standard_uncertainty: Option<f64>,
    /// Degrees of freedom of the uncertainty; `null` where it is known exactly.
    pub degrees_of_freedom: Option<f64>,
    /// Lower end of the interval of 95 %.
    pub low_95: Option<f64>,
    /// Upper end.
    pub high_95: Option<f64>,
}

impl Estimate {
    fn new(of: &EstimateFact, unit: &'static str) -> Estimate {
        let (low, high) = of.interval();
        Estimate {
            value: finite(of.value),
            unit,
            standard_uncertainty: finite(of.standard_uncertainty),
            degrees_of_freedom: finite(of.freedom),
            low_95: finite(low),
            high_95: finite(high),
        }
    }
}

/// What one log gave.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct OfLog<'a> {
    /// The log.
    pub log: &'a str,
    /// Whether the result rests on it.
    pub used: bool,
    /// Numbers by their names.
    pub values: Estimates<'a>,
    /// What should be known.
    pub remarks: &'a [String],
}

/// Numbers by their names.
#[derive(Debug)]
pub struct Estimates<'a>(&'a [(&'static str, EstimateFact, &'static str)]);

impl Serialize for Estimates<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, estimate, unit)| (name, Estimate::new(estimate, unit))))
    }
}

#[cfg(feature = "schema")]
impl JsonSchema for Estimates<'_> {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "Estimates".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "object", "additionalProperties": generator.subschema_for::<Estimate>() })
    }
}

/// What a check says.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Finding<'a> {
    /// The check.
    pub check: &'static str,
    /// `good`, `note` or `warning`.
    pub weight: &'static str,
    /// In words.
    pub text: &'a str,
}

fn findings(of: &[fact::Finding]) -> Vec<Finding<'_>> {
    of.iter().map(|f| Finding { check: f.check, weight: f.weight.word(), text: &f.text }).collect()
}

/// A catalogue row.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Row<'a> {
    /// Id.
    pub id: &'a str,
    /// Who makes the motor.
    pub manufacturer: &'a str,
    /// What its maker calls it.
    pub model: &'a str,
    /// `brushless` or `brushed`.
    pub commutation: &'static str,
    /// `wye` or `delta`, where it was seen.
    pub winding: Option<&'static str>,
    /// Pole pairs.
    pub pole_pairs: Option<u32>,
    /// Whether a catalogue can read it.
    pub complete: bool,
    /// What a catalogue needs and it does not have.
    pub missing: &'a [&'static str],
    /// Columns that were measured.
    pub measured: &'a [&'static str],
    /// Columns that were not.
    pub taken: Vec<Taken<'a>>,
    /// The numbers with their ± (95 %), SI.
    numbers: Numbers<'a>,
    /// Where the numbers come from.
    pub source: &'a str,
    /// By which methods.
    pub note: &'a str,
}

/// A column that was not measured.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Taken<'a> {
    /// The column.
    pub column: &'static str,
    /// Where its number is from.
    pub from: &'a str,
}

/// The numbers of a row, those that are known; each column once, from the list of columns.
#[derive(Debug)]
struct Numbers<'a>(&'a Sheet);

/// Keys of a column's number and of its ±.
fn keys(field: &Field) -> [String; 2] {
    let unit = field.kind.si.replace('/', "_per_").replace(['*', '^', '(', ')'], "");
    let unit = unit.replace("1_per_", "per_").to_lowercase();
    [format!("{}_{unit}", field.name), format!("{}_tolerance_{unit}", field.name)]
}

impl Serialize for Numbers<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        for field in FIELDS {
            let Some(printed) = (field.get)(self.0) else { continue };
            let [value, tolerance] = keys(field);
            map.serialize_entry(&value, &printed.value)?;
            if let Some(of) = printed.tolerance {
                map.serialize_entry(&tolerance, &of)?;
            }
        }
        map.end()
    }
}

#[cfg(feature = "schema")]
impl JsonSchema for Numbers<'_> {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "Numbers".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let mut properties = serde_json::Map::new();
        for field in FIELDS {
            let [value, tolerance] = keys(field);
            properties.insert(value, number_or_null(&field.about.replace("\\[", "[").replace("\\]", "]")).to_value());
            properties.insert(tolerance, number_or_null("its ± (95 %)").to_value());
        }
        json_schema!({ "type": "object", "properties": properties, "additionalProperties": false })
    }
}

/// A log.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Log<'a> {
    /// Its name.
    pub log: &'a str,
    /// How it was taken.
    pub kind: &'static str,
    /// SHA-256 of the file.
    pub sha256: &'a str,
    /// Lines.
    pub rows: usize,
    /// What was noticed in reading it.
    pub remarks: &'a [String],
}

/// What a bench says of its motor.
pub fn json(bench: &Bench, result: &Characterization) -> Value {
    let logs = bench.logs.iter().map(|l| Log {
        log: &l.name,
        kind: l.kind.name(),
        sha256: &l.hash,
        rows: l.len(),
        remarks: &l.remarks,
    });
    document(
        "characterize",
        Answer {
            bench: &bench.name,
            ratio: bench.declared.ratio,
            tests: result.outcomes.iter().map(Test::new).collect(),
            findings: findings(&result.findings),
            row: Row::new(&result.row),
            logs: logs.collect(),
        },
    )
}

impl<'a> Test<'a> {
    fn new(of: &'a fact::Outcome) -> Test<'a> {
        let quantity = |q: &'a fact::Quantity| Quantity {
            name: q.name,
            estimate: Estimate::new(&q.estimate, q.unit),
            remark: &q.remark,
        };
        let log = |l: &'a fact::PerLog| OfLog {
            log: &l.log,
            used: l.used,
            values: Estimates(&l.values),
            remarks: &l.remarks,
        };
        Test {
            test: of.test,
            method: &of.method,
            quantities: of.quantities.iter().map(quantity).collect(),
            logs: of.logs.iter().map(log).collect(),
            findings: findings(&of.findings),
        }
    }
}

impl<'a> Row<'a> {
    fn new(row: &'a RowFact) -> Row<'a> {
        Row {
            id: &row.id,
            manufacturer: &row.manufacturer,
            model: &row.model,
            commutation: word(Commutation::NAMES, &row.commutation),
            winding: row.winding.map(|w| word(Winding::NAMES, &w)),
            pole_pairs: row.pole_pairs,
            complete: row.missing.is_empty(),
            missing: &row.missing,
            measured: &row.measured,
            taken: row.taken.iter().map(|(column, from)| Taken { column, from }).collect(),
            numbers: Numbers(&row.sheet),
            source: &row.source,
            note: &row.note,
        }
    }
}
