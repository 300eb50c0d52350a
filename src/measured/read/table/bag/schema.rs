//! Message definitions of ROS (`ros2msg`, `ros1msg`): the fields of a message and of those inside it.

use std::collections::BTreeMap;

/// What a field holds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Type {
    /// A truth value.
    Bool,
    /// A whole number of so many bytes, with sign or without.
    Whole(usize, bool),
    /// A floating-point number of so many bytes.
    Float(usize),
    /// A text.
    Text,
    /// A time, of seconds and nanoseconds.
    Time,
    /// A duration, of seconds and nanoseconds.
    Duration,
    /// Another message, by its place in the schema.
    Message(usize),
    /// So many elements.
    Array(Box<Type>, usize),
    /// As many elements as there are.
    Sequence(Box<Type>),
}

/// The fields of each message, the outer one first.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Schema {
    /// The messages.
    pub messages: Vec<Vec<(String, Type)>>,
}

/// A message inside itself, or too many inside one another.
const DEPTH: usize = 32;

impl Schema {
    /// Parses the definition of a message, with those that it needs after it.
    ///
    /// # Errors
    /// A line that is no field, a type that is not defined.
    pub fn parse(name: &str, text: &str) -> Result<Schema, String> {
        // Lines of each message; the first is the one that the schema is of.
        let mut texts: Vec<(String, Vec<&str>)> = vec![(short(name), Vec::new())];
        for line in text.lines() {
            let line = line.trim();
            if let Some(next) = line.strip_prefix("MSG:") {
                texts.push((short(next.trim()), Vec::new()));
            } else if !line.starts_with("===") {
                texts.last_mut().into_iter().for_each(|(_, lines)| lines.push(line));
            }
        }
        let places: BTreeMap<&str, usize> =
            texts.iter().enumerate().map(|(k, (name, _))| (name.as_str(), k)).rev().collect();
        let mut messages = Vec::new();
        for (name, lines) in &texts {
            let package = name.split_once('/').map_or("", |(package, _)| package);
            let mut fields = Vec::new();
            for line in lines {
                if let Some(field) = field(line, package, &places)? {
                    fields.push(field);
                }
            }
            messages.push(fields);
        }
        let schema = Schema { messages };
        if schema.depth(0, 0) > DEPTH {
            return Err(format!("messages are nested too deep in {name}"));
        }
        Ok(schema)
    }

    fn depth(&self, message: usize, above: usize) -> usize {
        if above > DEPTH {
            return above;
        }
        let inner = |kind: &Type| {
            let mut kind = kind;
            while let Type::Array(of, _) | Type::Sequence(of) = kind {
                kind = of;
            }
            if let Type::Message(inner) = kind { self.depth(*inner, above + 1) } else { above + 1 }
        };
        self.messages[message].iter().map(|(_, kind)| inner(kind)).max().unwrap_or(above + 1)
    }
}

/// `package/msg/Name` and `package/Name` are one.
fn short(name: &str) -> String {
    name.replace("/msg/", "/")
}

/// A field of a line; `None` for a comment, a constant and a blank line.
fn field(line: &str, package: &str, places: &BTreeMap<&str, usize>) -> Result<Option<(String, Type)>, String> {
    let line = line.split('#').next().unwrap_or("").trim();
    let mut words = line.split_whitespace();
    let (Some(kind), Some(name)) = (words.next(), words.next()) else {
        return if line.is_empty() { Ok(None) } else { Err(format!("`{line}` is no field of a message")) };
    };
    // A constant; a default stands after a name without one.
    if name.contains('=') || words.next().is_some_and(|word| word.starts_with('=')) {
        return Ok(None);
    }
    Ok(Some((name.to_string(), type_of(kind, package, places)?)))
}

fn type_of(written: &str, package: &str, places: &BTreeMap<&str, usize>) -> Result<Type, String> {
    if let Some((of, size)) = written.strip_suffix(']').and_then(|rest| rest.rsplit_once('[')) {
        let of = Box::new(type_of(of, package, places)?);
        return match size {
            "" => Ok(Type::Sequence(of)),
            size if size.starts_with("<=") => Ok(Type::Sequence(of)),
            size => match size.parse::<usize>() {
                Ok(size) if size <= 1 << 20 => Ok(Type::Array(of, size)),
                _ => Err(format!("`{written}` is no type")),
            },
        };
    }
    // A text may have a bound.
    let plain = written.split("<=").next().unwrap_or(written);
    Ok(match plain {
        "bool" => Type::Bool,
        "byte" | "char" | "uint8" => Type::Whole(1, false),
        "int8" => Type::Whole(1, true),
        "uint16" => Type::Whole(2, false),
        "int16" => Type::Whole(2, true),
        "uint32" => Type::Whole(4, false),
        "int32" => Type::Whole(4, true),
        "uint64" => Type::Whole(8, false),
        "int64" => Type::Whole(8, true),
        "float32" => Type::Float(4),
        "float64" => Type::Float(8),
        "string" => Type::Text,
        "wstring" => return Err("it has texts of wide characters (wstring)".into()),
        "time" | "builtin_interfaces/Time" | "builtin_interfaces/msg/Time" => Type::Time,
        "duration" | "builtin_interfaces/Duration" | "builtin_interfaces/msg/Duration" => Type::Duration,
        other => {
            let name = short(other);
            let own = format!("{package}/{name}");
            let header = if name == "Header" { "std_msgs/Header" } else { "" };
            let place = [name.as_str(), own.as_str(), header].into_iter().find_map(|name| places.get(name));
            Type::Message(*place.ok_or_else(|| format!("its definition lacks the type `{other}`"))?)
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_definition_with_its_parts() {
        let text = "# a comment\nuint8 OK=1\nstring MODE = \"a\"\nstd_msgs/Header header\n\nfloat64[] v # with a comment\n\
                    float32[3] w\nstring<=8 id\nint16 count 5\nPart[<=2] parts\n====\nMSG: std_msgs/Header\n\
                    builtin_interfaces/Time stamp\nstring frame_id\n====\nMSG: pkg/Part\nbool on\nduration d\n";
        let schema = Schema::parse("pkg/msg/Thing", text).unwrap();
        let field = |name: &str, kind: Type| (name.to_string(), kind);
        let list = |of: Type| Type::Sequence(Box::new(of));
        assert_eq!(
            schema.messages,
            [
                vec![
                    field("header", Type::Message(1)),
                    field("v", list(Type::Float(8))),
                    field("w", Type::Array(Box::new(Type::Float(4)), 3)),
                    field("id", Type::Text),
                    field("count", Type::Whole(2, true)),
                    field("parts", list(Type::Message(2))),
                ],
                vec![field("stamp", Type::Time), field("frame_id", Type::Text)],
                vec![field("on", Type::Bool), field("d", Type::Duration)],
            ]
        );
        for (text, part) in [
            ("float64", "`float64` is no field"),
            ("Other x", "lacks the type `Other`"),
            ("wstring x", "wstring"),
            ("float64[x] y", "is no type"),
            ("Self x\n===\nMSG: pkg/Self\nSelf again", "nested too deep"),
        ] {
            let error = Schema::parse("pkg/A", text).unwrap_err();
            assert!(error.contains(part), "{error}");
        }
    }
}
