//! A decoded message, whatever its encoding: a tree whose leaves are columns.
//!
//! An element of a list is named by the list of names beside it, as `velocity` of sensor_msgs/JointState by `name`; where there
//! is none of the same length, by its number from 0.

use std::borrow::Cow;

use serde_json::Value;

use gearwise_model::input::limits;

/// A part of a message.
#[derive(Debug, Clone, PartialEq)]
pub enum Node {
    /// One value.
    Leaf(Leaf),
    /// Fields with their names.
    Struct(Vec<(String, Node)>),
    /// Elements.
    List(Vec<Node>),
}

/// One value of a message.
#[derive(Debug, Clone, PartialEq)]
pub enum Leaf {
    /// A number; NaN is missing.
    Number(f64),
    /// A time \[ns\].
    Stamp(u64),
    /// A text or a truth value.
    Text(String),
}

/// Whether a field holds the names of the elements beside it.
fn holds_names(field: &str) -> bool {
    field == "name" || field == "names" || field.ends_with("_names")
}

/// What follows a part of a path.
fn after<'p>(path: &'p str, part: &str) -> Option<&'p str> {
    let rest = path.strip_prefix(part)?;
    if rest.is_empty() { Some(rest) } else { rest.strip_prefix('/') }
}

impl Node {
    /// The value at a path.
    pub fn at(&self, path: &str) -> Option<Leaf> {
        self.find(path, &[])
    }

    fn find(&self, path: &str, names: &[&str]) -> Option<Leaf> {
        match self {
            Node::Leaf(leaf) => path.is_empty().then(|| leaf.clone()),
            Node::Struct(fields) => {
                let own = own_names(fields);
                let names = own.as_deref().unwrap_or(names);
                fields.iter().find_map(|(field, node)| node.find(after(path, field)?, names))
            }
            Node::List(elements) if names.len() == elements.len() => {
                names.iter().zip(elements).find_map(|(name, node)| node.find(after(path, name)?, &[]))
            }
            Node::List(elements) => {
                let (number, rest) = path.split_once('/').unwrap_or((path, ""));
                // A number has one way to be written.
                let at = number.parse::<usize>().ok().filter(|at| at.to_string() == number)?;
                elements.get(at)?.find(rest, &[])
            }
        }
    }

    /// The paths of its values, at most so many, without those that are too long to be read.
    pub fn names(&self, most: usize) -> Vec<String> {
        let mut found = Vec::new();
        self.list("", &[], most, &mut found);
        found
    }

    fn list(&self, path: &str, names: &[&str], most: usize, found: &mut Vec<String>) {
        let below = |part: &str| {
            let joined = || if path.is_empty() { part.to_string() } else { format!("{path}/{part}") };
            (path.len() + part.len() < limits::NAME_BYTES).then(joined)
        };
        if found.len() >= most {
            return;
        }
        match self {
            Node::Leaf(_) => found.push(path.to_string()),
            Node::Struct(fields) => {
                let own = own_names(fields);
                let names = own.as_deref().unwrap_or(names);
                for (field, node) in fields {
                    if found.len() >= most {
                        return;
                    }
                    if !holds_names(field) || !matches!(node, Node::List(_)) {
                        below(field).into_iter().for_each(|path| node.list(&path, names, most, found));
                    }
                }
            }
            Node::List(elements) => {
                for (k, node) in elements.iter().enumerate() {
                    if found.len() >= most {
                        return;
                    }
                    let part =
                        if names.len() == elements.len() { Cow::Borrowed(names[k]) } else { Cow::Owned(k.to_string()) };
                    below(&part).into_iter().for_each(|path| node.list(&path, &[], most, found));
                }
            }
        }
    }
}

/// The names that a field of a message holds for the lists beside it.
fn own_names(fields: &[(String, Node)]) -> Option<Vec<&str>> {
    let list = fields.iter().find_map(|(field, node)| match node {
        Node::List(elements) if holds_names(field) && !elements.is_empty() => Some(elements),
        _ => None,
    })?;
    list.iter()
        .map(|node| match node {
            Node::Leaf(Leaf::Text(text)) => Some(text.as_str()),
            _ => None,
        })
        .collect()
}

/// A time of seconds and nanoseconds \[ns\]; `None` before 1970.
pub fn stamp(seconds: i64, nanoseconds: u32) -> Option<u64> {
    u64::try_from(seconds).ok()?.checked_mul(1_000_000_000)?.checked_add(u64::from(nanoseconds))
}

/// Lists and tables inside one another in a message.
const DEPTH: usize = 64;

/// The tree of a JSON value. A table of `sec` and `nsec` or `nanosec` is a time.
pub fn of_json(value: &Value, depth: usize) -> Node {
    let nothing = Node::Leaf(Leaf::Number(f64::NAN));
    if depth > DEPTH {
        return nothing;
    }
    match value {
        Value::Null => nothing,
        Value::Bool(truth) => Node::Leaf(Leaf::Text(truth.to_string())),
        Value::Number(number) => Node::Leaf(Leaf::Number(number.as_f64().unwrap_or(f64::NAN))),
        Value::String(text) => Node::Leaf(Leaf::Text(text.clone())),
        Value::Array(elements) => Node::List(elements.iter().map(|e| of_json(e, depth + 1)).collect()),
        Value::Object(fields) => {
            let part = |names: &[&str]| names.iter().find_map(|name| fields.get(*name));
            let time = part(&["sec", "secs"])
                .and_then(Value::as_i64)
                .zip(part(&["nsec", "nanosec", "nsecs"]).and_then(Value::as_u64));
            if let Some((seconds, nanoseconds)) = time.filter(|_| fields.len() == 2)
                && let Some(stamp) = u32::try_from(nanoseconds).ok().and_then(|n| stamp(seconds, n))
            {
                return Node::Leaf(Leaf::Stamp(stamp));
            }
            Node::Struct(fields.iter().map(|(name, value)| (name.clone(), of_json(value, depth + 1))).collect())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(text: &str) -> Node {
        of_json(&serde_json::from_str(text).unwrap(), 0)
    }

    #[test]
    fn elements_are_named_by_the_names_beside_them_or_by_numbers() {
        let states = message(
            r#"{"header": {"stamp": {"sec": 1, "nanosec": 5}}, "name": ["knee", "arm/elbow"],
                "position": [1, 2], "velocity": [3, 4], "effort": [7], "empty": []}"#,
        );
        let number = |x| Some(Leaf::Number(x));
        assert_eq!(states.at("velocity/knee"), number(3.0));
        assert_eq!(states.at("position/arm/elbow"), number(2.0));
        assert_eq!(states.at("effort/0"), number(7.0), "no name for each");
        assert_eq!(states.at("header/stamp"), Some(Leaf::Stamp(1_000_000_005)));
        for path in ["velocity/0", "velocity", "velocity/kne", "effort/knee", "effort/00", "empty/0", "header", "", "x"]
        {
            assert_eq!(states.at(path), None, "{path}");
        }
        let names =
            ["header/stamp", "position/knee", "position/arm/elbow", "velocity/knee", "velocity/arm/elbow", "effort/0"];
        assert_eq!(states.names(100), names);
        assert_eq!(states.names(2), names[..2]);
        // The names reach into parts of the message, and end at the elements that they name.
        let controller = message(
            r#"{"joint_names": ["a", "b"], "reference": {"positions": [1, 2]}, "more": [{"v": [5, 6]}, {"v": 7}]}"#,
        );
        assert_eq!(controller.at("reference/positions/b"), number(2.0));
        assert_eq!(controller.at("more/a/v/1"), number(6.0));
        assert_eq!(controller.at("more/b/v"), number(7.0));
    }
}
