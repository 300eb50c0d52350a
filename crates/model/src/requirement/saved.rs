//! A requirement whose motions were handed over, as files: each motion has one of its own, or its points in the text.

use std::collections::HashMap;

use toml_edit::{DocumentMut, InlineTable, Item, Table, TableLike, Value};

use crate::motion::Point;

/// What takes the place of a motion that was handed over.
#[derive(Debug, Clone)]
pub enum Kept {
    /// A file next to the requirement.
    File {
        /// Its name.
        name: String,
        /// Whether the motion repeats.
        periodic: bool,
        /// Its period \[s\], where the file does not say it.
        period: Option<f64>,
    },
    /// Operating points.
    Points(Vec<Point>),
}

/// The motions that a requirement names, each with the joint, and the load case, that names it first.
pub fn users(text: &str) -> Vec<(String, String)> {
    let mut found: Vec<(String, String)> = Vec::new();
    let Ok(mut document) = text.parse::<DocumentMut>() else { return found };
    each(document.as_table_mut(), "", &mut |table, who| {
        if let Some(name) = table.get("motion").and_then(Item::as_str)
            && found.iter().all(|(known, _)| known != name)
        {
            found.push((name.to_string(), who.to_string()));
        }
    });
    found
}

/// The text of a requirement with what takes the place of each motion that was handed over, with the factors on its torque and speed.
pub fn with_motions(text: &str, motions: &HashMap<String, (Kept, (f64, f64))>) -> String {
    let Ok(mut document) = text.parse::<DocumentMut>() else { return text.to_string() };
    each(document.as_table_mut(), "", &mut |table, _| {
        let Some((kept, factors)) = table.get("motion").and_then(Item::as_str).and_then(|name| motions.get(name))
        else {
            return;
        };
        match kept {
            Kept::File { name, periodic, period } => {
                table.insert("motion", toml_edit::value(name));
                if !periodic {
                    table.insert("periodic", toml_edit::value(false));
                }
                if let Some(period) = period {
                    table.insert("period", toml_edit::value(format!("{period} s")));
                }
            }
            Kept::Points(points) => {
                table.remove("motion");
                let points: toml_edit::Array = points.iter().map(as_table).collect();
                table.insert("points", toml_edit::value(points));
            }
        }
        for (name, factor) in [("torque", factors.0), ("speed", factors.1)].into_iter().filter(|(_, f)| *f != 1.0) {
            multiply(table, name, factor);
        }
    });
    document.to_string()
}

/// Multiplies a factor of a joint or a load case.
pub(super) fn multiply(table: &mut dyn TableLike, name: &str, factor: f64) {
    if !table.contains_key("scale") {
        table.insert("scale", Item::Value(Value::InlineTable(InlineTable::new())));
    }
    let Some(scale) = table.get_mut("scale").and_then(Item::as_table_like_mut) else { return };
    let number = |item: &Item| item.as_float().or(item.as_integer().map(|whole| whole as f64));
    let before = scale.get(name).and_then(number).unwrap_or(1.0);
    scale.insert(name, toml_edit::value(before * factor));
}

fn as_table(point: &Point) -> Value {
    let mut table = InlineTable::new();
    let always = [("torque", point.torque, "N*m"), ("speed", point.velocity, "rad/s")];
    let others = [
        ("acceleration", point.acceleration, "rad/s^2"),
        ("torque_rate", point.torque_rate, "N*m/s"),
        ("jerk", point.jerk, "rad/s^3"),
        ("duration", point.duration.unwrap_or(0.0), "s"),
    ];
    for (name, value, unit) in always.into_iter().chain(others.into_iter().filter(|(_, value, _)| *value != 0.0)) {
        table.insert(name, format!("{value} {unit}").into());
    }
    Value::InlineTable(table)
}

/// Goes through every table of a file, each with the names of the joint and the load case that it is in.
fn each(table: &mut dyn TableLike, who: &str, look: &mut impl FnMut(&mut dyn TableLike, &str)) {
    let own = table.get("name").and_then(Item::as_str).unwrap_or_default().to_string();
    look(table, who);
    for (key, item) in table.iter_mut() {
        let key = key.get().to_string();
        let mut inner = |table: &mut dyn TableLike| {
            let name = table.get("name").and_then(Item::as_str).unwrap_or(&key).to_string();
            // The robot's own name says nothing.
            let who = if who.is_empty() || own.is_empty() { name } else { format!("{who}-{name}") };
            each(table, &who, look);
        };
        match item {
            Item::Table(table) => inner(table),
            Item::ArrayOfTables(tables) => tables.iter_mut().for_each(|table: &mut Table| inner(table)),
            Item::Value(Value::InlineTable(table)) => inner(table),
            Item::Value(Value::Array(items)) => {
                items.iter_mut().filter_map(Value::as_inline_table_mut).for_each(|table| inner(table));
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "name = \"leg\"\n# The knee.\n[[joint]]\nname = \"knee\"\nmotion = \"a\"\nscale = { torque = 2 }\n\n[[joint]]\nname = \"hip\"\n[[joint.case]]\nname = \"walk\"\nmotion = \"b\"\n[[joint.case]]\nname = \"stand\"\nmotion = \"c.csv\"\n";

    #[test]
    fn motions_are_named_after_who_has_them_and_take_their_places() {
        let users = users(TEXT);
        let of = |motion: &str| users.iter().find(|(name, _)| name == motion).map(|(_, who)| who.as_str());
        assert_eq!([of("a"), of("b"), of("c.csv")], [Some("knee"), Some("hip-walk"), Some("hip-stand")]);
        let file = Kept::File { name: "knee.csv".into(), periodic: false, period: None };
        let point = Point { torque: 2.0, velocity: -1.0, duration: Some(0.5), ..Point::default() };
        let motions = HashMap::from([
            ("a".to_string(), (file, (1.5, 1.0))),
            ("b".to_string(), (Kept::Points(vec![point]), (1.0, 1.0))),
        ]);
        let text = with_motions(TEXT, &motions);
        assert!(
            text.contains("# The knee.") && text.contains("motion = \"knee.csv\"") && text.contains("periodic = false")
        );
        assert!(text.contains("torque = 3.0"), "{text}");
        let points = "points = [{ torque = \"2 N*m\", speed = \"-1 rad/s\", duration = \"0.5 s\" }]";
        assert!(text.contains(points) && text.contains("motion = \"c.csv\"") && !text.contains("\"b\""), "{text}");
    }
}
