//! Message definitions of ROS (`ros2msg`, `ros1msg`): the fields of a message and of those inside it.

use std::collections::BTreeMap;

use super::super::record::short as short_cell;
use gearwise_model::input::limits::SCHEMA_DEPTH;

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

impl Schema {
    /// Parses the definition of a message, with those that it needs after it. Fields without any value are left out:
    /// they take no bytes, however many there are.
    ///
    /// # Errors
    /// A line that is no field, a type that is not defined, a message that contains itself or is nested too deep.
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
        let mut schema = Schema { messages };
        let mut heights = vec![None; schema.messages.len()];
        schema.measure(0, 0, &mut heights).ok_or_else(|| format!("messages are nested too deep in {}", shown(name)))?;
        let mut holds: Vec<Option<bool>> = vec![None; schema.messages.len()];
        schema.find_values(0, &mut holds);
        for fields in &mut schema.messages {
            fields.retain(|(_, kind)| kind.holds_values(&holds));
        }
        Ok(schema)
    }

    /// Count the levels of a message that is nested in `above` others, each message once. `None` beyond [`SCHEMA_DEPTH`],
    /// which a message that contains itself reaches.
    fn measure(&self, message: usize, above: usize, heights: &mut [Option<usize>]) -> Option<usize> {
        if let Some(height) = heights[message] {
            return (above + height <= SCHEMA_DEPTH).then_some(height);
        }
        if above >= SCHEMA_DEPTH {
            return None;
        }
        let mut height = 1;
        for inner in self.messages[message].iter().filter_map(|(_, kind)| kind.message()) {
            height = height.max(1 + self.measure(inner, above + 1, heights)?);
        }
        heights[message] = Some(height);
        Some(height)
    }

    /// Note for a message and those inside it if they hold any value. Their depth is bounded before.
    fn find_values(&self, message: usize, holds: &mut [Option<bool>]) {
        if holds[message].is_some() {
            return;
        }
        for inner in self.messages[message].iter().filter_map(|(_, kind)| kind.message()) {
            self.find_values(inner, holds);
        }
        holds[message] = Some(self.messages[message].iter().any(|(_, kind)| kind.holds_values(holds)));
    }
}

impl Type {
    /// The message that a field is of, or that its elements are of.
    fn message(&self) -> Option<usize> {
        match self {
            Type::Message(at) => Some(*at),
            Type::Array(of, _) | Type::Sequence(of) => of.message(),
            _ => None,
        }
    }

    /// True unless a field is made of messages without fields, or of no elements. The length of a sequence is written
    /// down, so it stays.
    fn holds_values(&self, holds: &[Option<bool>]) -> bool {
        match self {
            Type::Message(at) => holds[*at] != Some(false),
            Type::Array(of, count) => *count > 0 && of.holds_values(holds),
            _ => true,
        }
    }

    /// True if an element of this type takes no bytes.
    pub fn is_empty(&self, schema: &Schema) -> bool {
        matches!(self, Type::Message(at) if schema.messages[*at].is_empty())
    }
}

/// `package/msg/Name` and `package/Name` are one.
fn short(name: &str) -> String {
    name.replace("/msg/", "/")
}

/// A part of a definition for a message.
fn shown(text: &str) -> String {
    short_cell(text.as_bytes())
}

/// A field of a line; `None` for a comment, a constant and a blank line.
fn field(line: &str, package: &str, places: &BTreeMap<&str, usize>) -> Result<Option<(String, Type)>, String> {
    let line = line.split('#').next().unwrap_or("").trim();
    let mut words = line.split_whitespace();
    let (Some(kind), Some(name)) = (words.next(), words.next()) else {
        return if line.is_empty() { Ok(None) } else { Err(format!("`{}` is no field of a message", shown(line))) };
    };
    // A constant; a default stands after a name without one.
    if name.contains('=') || words.next().is_some_and(|word| word.starts_with('=')) {
        return Ok(None);
    }
    Ok(Some((name.to_string(), type_of(kind, package, places)?)))
}

fn type_of(written: &str, package: &str, places: &BTreeMap<&str, usize>) -> Result<Type, String> {
    if let Some((of, size)) = written.strip_suffix(']').and_then(|rest| rest.rsplit_once('[')) {
        // Arrays of arrays do not exist in these languages.
        if of.ends_with(']') {
            return Err(format!("`{}` is no type", shown(written)));
        }
        let of = Box::new(type_of(of, package, places)?);
        return match size {
            "" => Ok(Type::Sequence(of)),
            size if size.starts_with("<=") => Ok(Type::Sequence(of)),
            size => match size.parse::<usize>() {
                Ok(size) if size <= 1 << 20 => Ok(Type::Array(of, size)),
                _ => Err(format!("`{}` is no type", shown(written))),
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
            Type::Message(*place.ok_or_else(|| format!("its definition lacks the type `{}`", shown(other)))?)
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
            ("float64[2][2] x", "is no type"),
        ] {
            let error = Schema::parse("pkg/A", text).unwrap_err();
            assert!(error.contains(part), "{error}");
        }
    }

    /// Messages that each have the next one `width` times; the last has `last`.
    fn chain(length: usize, width: usize, last: &str) -> String {
        let fields = |k: usize| (0..width).map(|j| format!("M{} f{j}\n", k + 1)).collect::<String>();
        let inner =
            |k: usize| format!("===\nMSG: p/M{k}\n{}", if k < length { fields(k) } else { format!("{last}\n") });
        fields(0) + &(1..=length).map(inner).collect::<String>()
    }

    #[test]
    fn each_message_is_measured_once() {
        // 3^31 paths lead through these messages.
        let wide = Schema::parse("p/M0", &chain(SCHEMA_DEPTH - 1, 3, "float64 x")).unwrap();
        assert_eq!(wide.messages.len(), SCHEMA_DEPTH);
        assert!(wide.messages[..SCHEMA_DEPTH - 1].iter().all(|fields| fields.len() == 3));
        assert!(Schema::parse("p/M0", &chain(SCHEMA_DEPTH, 1, "float64 x")).is_err());
        assert!(Schema::parse("p/M0", &chain(SCHEMA_DEPTH - 1, 3, "M0 again")).is_err());
        // The deeper way to a message is found after the shallower one.
        let twice = format!("M{} shallow\n{}", SCHEMA_DEPTH - 1, chain(SCHEMA_DEPTH, 1, "float64 x"));
        assert!(Schema::parse("p/M0", &twice).is_err());
    }

    #[test]
    fn arrays_of_arrays_are_refused_at_any_length() {
        assert!(Schema::parse("p/A", &format!("float64{} x", "[]".repeat(1_000_000))).is_err());
    }

    #[test]
    fn fields_without_values_are_left_out() {
        let text = "Empty[1048576] a\nNest b\nfloat64[0] c\nEmpty[] d\nuint8 e\n===\nMSG: p/Empty\nuint8 K=1\n===\n\
                    MSG: p/Nest\nEmpty[1048576] x\nEmpty y\n";
        let schema = Schema::parse("p/A", text).unwrap();
        let names: Vec<&str> = schema.messages[0].iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["d", "e"]);
        assert!(schema.messages[1..].iter().all(Vec::is_empty));
    }
}
