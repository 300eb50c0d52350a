//! A page that needs no program: the answers at every point of a grid are in it.

use std::sync::Mutex;

use rayon::prelude::*;
use serde_json::{Map, Value, json};

use super::page::{Demo, demo};
use super::state::{Ask, overlap};
use super::work::{Next, Work};
use super::{Explorer, controls};
use crate::ask::Failure;

/// Most answers in one page: points of the grid times joints.
pub const MOST: usize = 400;

/// One parameter of the grid.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Axis {
    /// Its key, as that of `--set`.
    pub key: String,
    /// Its values, as in a requirement's file.
    pub values: Vec<String>,
}

impl Axis {
    /// An axis as it is typed: `KEY=VALUE,VALUE,…`.
    ///
    /// # Errors
    /// In words: what is no such thing, fewer than two values, one of them twice.
    pub fn read(text: &str) -> Result<Axis, String> {
        let wrong = |what: &str| {
            Err(format!("`--grid {text}`: {what}; write KEY=VALUE,VALUE, as in 'bus.voltage=24 V,36 V,48 V'"))
        };
        let Some((key, values)) = text.split_once('=') else { return wrong("there is no `=`") };
        let values = apart(values);
        if key.trim().is_empty() || values.iter().any(String::is_empty) {
            return wrong("a key or a value is missing");
        }
        if values.len() < 2 {
            return wrong("a slider needs two values at least");
        }
        if (1..values.len()).any(|k| values[..k].contains(&values[k])) {
            return wrong("a value is there twice");
        }
        Ok(Axis { key: key.trim().to_string(), values })
    }

    /// That no key stands twice, nor one that the page begins with.
    ///
    /// # Errors
    /// Which does.
    pub fn check(axes: &[Axis], explorer: &Explorer) -> Result<(), String> {
        for (k, axis) in axes.iter().enumerate() {
            if let Some(other) = axes[..k].iter().find(|other| overlap(&other.key, &axis.key)) {
                return Err(format!("`--grid {}`: this key has values already, by `{}`", axis.key, other.key));
            }
            if explorer.begins_with(&axis.key) {
                return Err(format!("`--grid {}`: `--set` gives this key a value", axis.key));
            }
        }
        Ok(())
    }

    /// What is taken where nothing is asked for: the bus voltage about that of the file, and factors on all torques.
    pub fn usual(explorer: &Explorer) -> Vec<Axis> {
        let voltage = explorer.robot().bus.voltage;
        let of = |factor: f64| format!("{} V", crate::report::number(voltage * factor));
        let all = [
            Axis { key: "bus.voltage".into(), values: [0.5, 0.75, 1.0, 1.5, 2.0].map(of).to_vec() },
            Axis { key: "scale.torque".into(), values: ["0.8", "1", "1.25"].map(str::to_string).to_vec() },
        ];
        all.into_iter().filter(|axis| !explorer.begins_with(&axis.key)).collect()
    }

    /// Which of the values is the file's, as the page begins.
    fn of_file(&self, explorer: &Explorer) -> usize {
        let begin = &explorer.ground.begin;
        let plain = explorer.robot_of(begin);
        let same = |value: &String| {
            let mut with = begin.clone();
            with.insert(self.key.clone(), value.clone());
            let with = explorer.robot_of(&with);
            match (&plain, with) {
                (Ok(plain), Ok(with)) => match self.key.as_str() {
                    "scale.torque" | "scale.speed" => value.parse::<f64>() == Ok(1.0),
                    _ => {
                        format!("{:?}", (&plain.bus, plain.ambient, &plain.joints))
                            == format!("{:?}", (&with.bus, with.ambient, &with.joints))
                    }
                },
                _ => false,
            }
        };
        self.values.iter().position(same).unwrap_or(0)
    }

    fn json(&self, explorer: &Explorer) -> Value {
        let named = controls::CONTROLS.iter().find(|control| control.key == self.key);
        json!({
            "key": self.key, "name": named.map_or(self.key.as_str(), |control| control.name), "unit": "", "values": self.values,
            "help": named.map_or("", |control| control.help), "joint": false, "at": 0, "file": self.of_file(explorer),
        })
    }
}

/// How many points a grid has; `None` where that is no number.
pub fn points(axes: &[Axis]) -> Option<usize> {
    axes.iter().try_fold(1_usize, |all, axis| all.checked_mul(axis.values.len()))
}

/// Values that stand apart by commas; those in brackets, braces and quotes are of one value.
fn apart(text: &str) -> Vec<String> {
    let (mut values, mut depth, mut quote) = (vec![String::new()], 0_i32, None);
    for c in text.chars() {
        match (quote, c) {
            (Some(open), _) if c == open => quote = None,
            (Some(_), _) => {}
            (None, '"' | '\'') => quote = Some(c),
            (None, '[' | '{') => depth += 1,
            (None, ']' | '}') => depth -= 1,
            (None, ',') if depth <= 0 => {
                values.push(String::new());
                continue;
            }
            (None, _) => {}
        }
        if let Some(last) = values.last_mut() {
            last.push(c);
        }
    }
    values.into_iter().map(|value| value.trim().to_string()).collect()
}

/// The page with the answers at every point of a grid; `tick` is called for each answer.
///
/// # Errors
/// A value that the requirement does not take, a grid that is too large, that it was stopped.
pub fn page(
    explorer: &Explorer,
    axes: &[Axis],
    tick: &(dyn Fn() + Sync),
    stop: &(dyn Fn() -> bool + Sync),
) -> Result<String, Failure> {
    let joints: Vec<&str> = explorer.robot().joints.iter().map(|joint| joint.name.as_str()).collect();
    Axis::check(axes, explorer).map_err(Failure::Argument)?;
    let points = points(axes);
    if points.is_none_or(|points| points.saturating_mul(joints.len()) > MOST) {
        let grid =
            points.map_or_else(|| "More points than can be counted".into(), |n| format!("{n} points of the grid"));
        let at = crate::words::counted(joints.len(), "joint");
        return Err(Failure::Argument(format!("{grid} at {at} are too many: a page holds {MOST} answers at most")));
    }
    let points = points.unwrap_or(0);
    let place = |mut point: usize| {
        let mut at = vec![0; axes.len()];
        for (k, axis) in axes.iter().enumerate().rev() {
            at[k] = point % axis.values.len();
            point /= axis.values.len();
        }
        at
    };
    let found = Mutex::new(Vec::new());
    let one = |(point, joint): (usize, &str)| -> Result<(), Failure> {
        if stop() {
            return Err(Failure::Interrupted("stopped: no page was written".into()));
        }
        let at = place(point);
        let set = axes.iter().zip(&at).map(|(axis, k)| (axis.key.clone(), axis.values[*k].clone()));
        let state = explorer.ground.begin.clone().into_iter().chain(set).collect();
        let ask = Ask { joint: joint.into(), state, ..Ask::default() };
        let answer = answer(explorer, ask)?;
        let name: Vec<String> = at.iter().map(usize::to_string).collect();
        found
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner)
            .push((format!("{}|{}", name.join(","), crate::report::html::shown(joint)), answer));
        tick();
        Ok(())
    };
    let all: Vec<(usize, &str)> =
        (0..points).flat_map(|point| joints.iter().map(move |joint| (point, *joint))).collect();
    all.into_par_iter().try_for_each(one)?;
    let answers = found.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner).into_iter().collect();
    let axes = axes.iter().map(|axis| axis.json(explorer)).collect();
    Ok(demo(explorer, &Demo { axes, answers }))
}

/// The whole answer to a question, as one.
fn answer(explorer: &Explorer, ask: Ask) -> Result<Value, Failure> {
    let work = Work::new(ask, Box::new(|| ()));
    explorer.run(&work);
    let (mut whole, mut views, mut joints) = (Map::new(), Map::new(), Vec::new());
    for have in 0.. {
        let reply = match work.next(have) {
            Next::Reply(reply) => reply,
            Next::Broken(what) => return Err(Failure::Argument(what)),
            Next::Pending(..) | Next::Nothing => break,
        };
        let Ok(Value::Object(mut reply)) = serde_json::from_str(&reply) else { break };
        if let Some(first) = reply.get("problems").and_then(Value::as_array).and_then(|all| all.first()) {
            let of = |key: &str| first[key].as_str().unwrap_or_default().to_string();
            return Err(Failure::Argument(format!("{}: {}", of("key"), of("message"))));
        }
        if let Some(Value::Object(more)) = reply.remove("views") {
            views.extend(more);
        }
        if let Some(Value::Array(more)) = reply.remove("joints") {
            joints.extend(more);
        }
        for key in ["ask", "pending", "state", "controls", "objective", "references"] {
            reply.remove(key);
        }
        whole.extend(reply);
    }
    whole.insert("views".into(), Value::Object(views));
    whole.insert("joints".into(), Value::Array(joints));
    Ok(Value::Object(whole))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_is_typed_as_a_key_with_values() {
        let axis = Axis::read("bus.voltage=24 V, 36 V").unwrap();
        assert_eq!((axis.key.as_str(), axis.values), ("bus.voltage", vec!["24 V".to_string(), "36 V".to_string()]));
        let axis = Axis::read("joint.a.objective={ loss = 1, mass = 2 },\"loss\", [1, 2]").unwrap();
        assert_eq!(axis.values, ["{ loss = 1, mass = 2 }", "\"loss\"", "[1, 2]"]);
        for wrong in ["bus.voltage", "bus.voltage=24 V", "=1,2", "a=1,,2", "a=1,1"] {
            assert!(Axis::read(wrong).unwrap_err().contains(wrong), "{wrong}");
        }
    }
}
