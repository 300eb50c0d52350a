//! The published schema of everything that `--json` prints, made of the objects that are printed.

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde_json::{Value, json};

use crate::report::json::{
    Envelope, catalog, characterize, check, check_model, explain, export, identify, identify_robot, import, motors,
    optimize, over, pareto, robust, rule, sweep, torques,
};
use crate::study::Summary;

/// What a command prints, as a schema.
type Shape = fn(&mut SchemaGenerator) -> Schema;

/// Every command that prints JSON, as its answer names it, with the shape of that answer.
const COMMANDS: &[(&str, Shape)] = &[
    ("optimize", shape::<optimize::Answer>),
    ("optimize --pareto", shape::<pareto::Answer>),
    ("optimize --search", shape::<over::Answer>),
    ("optimize --robust", shape::<robust::Answer>),
    ("sweep", shape::<sweep::Answer>),
    ("explain", shape::<explain::Answer>),
    ("check", shape::<check::Printed>),
    ("check-model", shape::<check_model::Printed>),
    ("rank", shape::<motors::Ranked>),
    ("compare", shape::<motors::Compared>),
    ("audit", shape::<motors::Audited>),
    ("catalog list", shape::<catalog::Listed>),
    ("catalog search", shape::<catalog::Listed>),
    ("catalog show", shape::<catalog::Shown>),
    ("audit against", shape::<catalog::Compared>),
    ("catalog diff", shape::<catalog::Differ>),
    ("catalog path", shape::<catalog::Paths>),
    ("torques", shape::<torques::Answer>),
    ("import", shape::<import::Answer>),
    ("export", shape::<export::Answer>),
    ("rule", shape::<rule::Answer>),
    ("identify", shape::<identify::Answer>),
    ("identify", shape::<identify_robot::Answer>),
    ("characterize", shape::<characterize::Answer>),
    ("study", shape::<Summary>),
];

fn shape<T: JsonSchema>(generator: &mut SchemaGenerator) -> Schema {
    generator.subschema_for::<Envelope<T>>()
}

/// The published schema (JSON Schema, 2020-12) of everything that `--json` prints.
pub fn schema() -> Value {
    let mut generator = SchemaSettings::draft2020_12().for_serialize().into_generator();
    let of = |(command, shape): &(&str, Shape)| {
        let answer = shape(&mut generator).to_value();
        json!({ "allOf": [answer, { "properties": { "command": { "const": command } } }] })
    };
    let any: Vec<Value> = COMMANDS.iter().map(of).collect();
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "gearwise --json",
        "description": "SI units, the unit in the key. A number that is not known, or that the command does not work out, is null.",
        "anyOf": any,
        "$defs": generator.take_definitions(true),
    })
}
