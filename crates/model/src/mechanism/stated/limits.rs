//! A table of limits (JSON): joint → effort, velocity, armature, friction, damping, gear, saturation, in SI at the joint.

use std::collections::HashSet;
use std::sync::Arc;

use super::{Form, Joint, Model, Quantity, Slot, Stated};
use crate::input::json::{self, Is, Value};
use crate::input::{InputError, Problem, Range, Source};
use crate::units;

pub(super) fn read(source: &Arc<Source>) -> Result<Model, InputError> {
    let root = json::read(source)?;
    let mut model = Model { source: source.clone(), ..Model::blank(Form::Limits, "limits") };
    let mut problems = Vec::new();
    let mut names = HashSet::new();
    let Is::Table(joints) = root.is else {
        let problem = Problem::at(root.span, "this is no table of joints", "expected {\"joint\": {\"effort\": …}}");
        return Err(InputError { source: source.clone(), problems: vec![problem] });
    };
    for (name, span, value) in joints {
        if !names.insert(name.clone()) {
            problems.push(Problem::at(span.clone(), format!("two joints are called `{name}`"), "second time"));
        }
        let (start, table) = match value {
            Value { is: Is::Table(table), span } => (span.start + 1, table),
            Value { span, .. } => {
                let label = "expected a table, {\"effort\": …}";
                problems.push(Problem::at(span, format!("`{name}` is no table of numbers"), label));
                continue;
            }
        };
        let mut joint =
            Joint { name, span, turns: true, is_passive: false, parent: None, stated: Vec::new(), blank: Vec::new() };
        let end = if table.is_empty() { "" } else { ", " };
        for (key, place, value) in table {
            match stated(&key, place, value) {
                Ok(stated) if joint.get(stated.quantity).is_some() => {
                    problems.push(Problem::at(stated.span, format!("two times `{key}`"), "second time"));
                }
                Ok(stated) => joint.stated.push(stated),
                Err(problem) => problems.push(problem),
            }
        }
        for (name, quantity) in Quantity::NAMES {
            if joint.get(*quantity).is_some() {
                continue;
            }
            let before = format!("\"{name}\": ");
            let slot = Slot { before, after: end.into(), ..Slot::replace(start..start) };
            joint.blank.push((*quantity, slot));
        }
        model.joints.push(joint);
    }
    InputError::unless_empty(source, problems)?;
    Ok(model)
}

fn stated(key: &str, place: std::ops::Range<usize>, value: Value) -> Result<Stated, Problem> {
    let Some((name, quantity)) = Quantity::NAMES.iter().find(|(name, _)| *name == key) else {
        let shown: String = key.chars().take(60).collect();
        let problem = Problem::at(place, format!("unknown key `{shown}` of a joint"), "not known here");
        return Err(problem.suggest(key, Quantity::NAMES.iter().map(|(name, _)| *name)));
    };
    let number = match value.is {
        Is::Number(number) => number,
        Is::Table(_) => return Err(Problem::at(value.span, format!("`{name}` is a table"), "expected a number in SI")),
        Is::Other(what) => {
            return Err(Problem::at(value.span, format!("`{name}` is {what}"), "expected a number in SI"));
        }
    };
    if !(units::is_sane(number) && Range::NonNegative.contains(number)) {
        let expected = format!("expected {}", Range::NonNegative.expected());
        return Err(Problem::at(value.span, format!("`{name}` is out of range"), expected));
    }
    let slot = Some(Slot::replace(value.span.clone()));
    Ok(Stated { quantity: *quantity, value: number, span: value.span, called: key.into(), slot, by_gear: false })
}
